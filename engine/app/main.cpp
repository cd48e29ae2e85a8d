// The program typodont: parses the command line, runs one command, and converts errors to messages and exit statuses.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <string>
#include <system_error>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/hands/hands.h"
#ifdef TYPODONT_WINDOW
#include "engine/app/operator/operator.h"
#endif
#include "engine/app/recording/replay_hand.h"
#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/harmless.h"
#include "engine/base/input_file.h"
#include "engine/base/interrupt.h"
#include "engine/base/log.h"
#include "engine/base/realtime.h"
#include "engine/gpu/driver_cache.h"

/// Flushes standard output. Returns the exit status: a failure if the output could not be written, for example on a
/// full disk.
static int written_out() {
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout) return 0;
  typodont::log::error("standard output: {}", std::strerror(errno ? errno : EIO));
  return 1;
}

/// Keeps control characters in file names from reaching a terminal through standard output.
static void print_harmless_text() {
  if (!::isatty(STDOUT_FILENO)) return;
  const cookie_io_functions_t functions{.read = nullptr,
                                        .write = [](void*, const char* text, std::size_t size) -> ssize_t {
                                          std::string harmless(text, size);
                                          typodont::make_harmless(harmless);
                                          return ::write(STDOUT_FILENO, harmless.data(), size);
                                        },
                                        .seek = nullptr,
                                        .close = nullptr};
  std::FILE* const terminal = ::fopencookie(nullptr, "w", functions);
  if (!terminal) return;
  std::setvbuf(terminal, nullptr, _IOLBF, BUFSIZ);
  stdout = terminal;
}

/// Prevents any write to standard error, even by a library, from waiting for a reader. A pipe or terminal is opened
/// again for this, because the non-blocking mode of the inherited file would also affect other programs.
static void never_wait_for_standard_error() {
  struct stat info {};
  if (::fstat(STDERR_FILENO, &info) != 0 || !(S_ISFIFO(info.st_mode) || S_ISCHR(info.st_mode))) return;
  const int own = ::open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (own < 0) return;
  ::dup2(own, STDERR_FILENO);
  ::close(own);
}

/// Opens /dev/null for each closed standard stream. Otherwise the next opened file would get the number of this stream,
/// and text for the terminal would be written into that file.
static void open_standard_streams() {
  for (int stream = 0; stream <= 2; ++stream) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    // open() returns the lowest free number, which must be the number of this closed stream.
    if (::open("/dev/null", O_RDONLY) != stream) std::abort();
  }
}

/// Runs the command that the command line names. Without a command, opens the operator's window. Returns the exit
/// status. Throws Error if the input is bad, and another exception if the run fails.
static int run_program(int argc, char** argv) {
  using namespace typodont;
  // The system sends SIGXFSZ if a file reaches its size limit, which would end a live session. If the signal is
  // ignored, the write fails instead, as on a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);  // if the output's reader closes the pipe, the session must not end
  end_cleanly_on_interrupt();
  if (argc > 1) remember_inputs();
  cli::Command program(
      "typodont", "Typodont: a co-located visual, haptic and audio workbench for hand-eye training on hard tissue");
  program.version(TYPODONT_VERSION);
  // Only the first word names a command; a later word may be an argument with the name of a command.
  program.expect_commands(0, 1);
  add_demo_command(program);
  add_servo_command(program);
  add_fit_material_command(program);
  add_import_command(program);
  add_fuse_command(program);
  add_case_command(program);
  add_next_command(program);
  add_mesh_command(program);
  add_volume_command(program);
  add_fit_damping_command(program);
  add_pack_command(program);
  add_plan_command(program);
  add_render_command(program);
  add_report_command(program);
  add_devices_command(program);
  add_doctor_command(program);
  add_experiment_command(program);
  add_repair_command(program);
  add_rescore_command(program);
  add_remark_command(program);
  add_sign_command(program);
  add_sound_command(program);
  add_calibrate_command(program);
  add_rig_command(program);
  add_replay_command(program);
  add_run_command(program);
  add_schema_command(program);
  add_replay_driver();
  add_window_drivers();
  program.footer("Without arguments, typodont opens the operator's window.");
  if (const auto kept = cache::folder("driver"); !kept.empty()) gpu::keep_driver_cache(kept);
  if (argc == 1) {
    try {
#ifdef TYPODONT_WINDOW
      run_operator();
      return 0;
#else
      throw Error("this build", "", "no window support", "a build with TYPODONT_WINDOW=ON");
#endif
    } catch (const Error& e) {
      log::error("The operator's window cannot be opened: {}", e.what());
      log::raw(program.help());
      return 2;
    }
  }
  const int status = program.run(argc, argv).value_or(0);
  return status == 0 ? written_out() : status;
}

int main(int argc, char** argv) {
  using namespace typodont;
  open_standard_streams();
  never_wait_for_standard_error();
  print_harmless_text();
  keep_freed_memory();
  try {
    return run_program(argc, argv);
  } catch (const Error& e) {
    log::error("{}", e.what());
    return 2;
  } catch (const std::system_error& e) {
    const bool no_thread = e.code() == std::errc::resource_unavailable_try_again;
    log::error("{}", no_thread ? "The operating system granted this program no more threads." : e.what());
    return 1;
  } catch (const std::exception& e) {
    log::error("{}", e.what());
    return 1;
  }
}
