// Runs the program as a user does. Takes its arguments, and returns its exit status, standard output and standard
// error.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <source_location>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "tests/support/folder.h"

namespace typodont::test {

/// Returns this text as the name of a test with a parameter: gtest allows no hyphen.
inline std::string test_name(std::string text) {
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}

/// The file of a live session's recording. The program creates the file first; the file grows when ticks are written.
class GrowingFile {
 public:
  explicit GrowingFile(std::filesystem::path file) : file_(std::move(file)) {}
  /// Returns true if the file is larger than at the first call that found it. The recording then contains ticks.
  bool has_grown() {
    std::error_code missing;
    const std::uintmax_t size = std::filesystem::file_size(file_, missing);
    if (missing) return false;
    if (first_ == 0) first_ = size;
    return size > first_;
  }

 private:
  std::filesystem::path file_;
  std::uintmax_t first_ = 0;  // bytes
};

struct Ran {
  int status = -1;
  std::string out, err;
  std::string command;  // without the program's name
};
/// Passes the result on. The test fails unless the program exited with `status` and its messages contain `words`.
inline Ran expect_exit(Ran ran, int status, const std::string& words,
                       const std::source_location& at = std::source_location::current()) {
  if (ran.status != status || ran.err.find(words) == std::string::npos) {
    ADD_FAILURE_AT(at.file_name(), static_cast<int>(at.line()))
        << ran.command << "\nstatus " << ran.status << ", expected " << status << " and \"" << words << "\"\n"
        << ran.out << ran.err;
  }
  return ran;
}
/// The test fails unless the program exited with 0.
inline Ran expect_ok(Ran ran, const std::source_location& at = std::source_location::current()) {
  return expect_exit(std::move(ran), 0, "", at);
}

/// A temporary folder for one test, which is removed at the end. Runs `typodont` in it and captures its output. In
/// arguments, {} stands for the folder.
class ProgramFolder : public TemporaryFolder {
 public:
  explicit ProgramFolder(std::string program) : program_(std::move(program)) {}
  std::string operator/(const std::string& name) const { return (path() / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path() / name, std::ios::binary) << text;
    return (path() / name).string();
  }
  std::string in_folder(std::string text) const {
    for (std::size_t at; (at = text.find("{}")) != std::string::npos;) text.replace(at, 2, path().string());
    return text;
  }
  /// Copies the shipped assets and adds `preset` as devices/NAME.json. Programs started later use this copy.
  std::string add_device(const std::string& name, const std::string& preset) const {
    const std::filesystem::path assets = path() / "assets";
    std::filesystem::create_directories(assets / "devices");
    for (const auto& entry : std::filesystem::directory_iterator("assets")) {
      if (entry.path().filename() != "devices") {
        std::filesystem::create_symlink(std::filesystem::absolute(entry.path()), assets / entry.path().filename());
      }
    }
    ::setenv("TYPODONT_ASSETS", assets.c_str(), 1);
    return write("assets/devices/" + name + ".json", preset);
  }
  /// Runs the program. `before`: text in front of the command, e.g. "timeout 5" or environment variables.
  Ran run(const std::string& arguments, const std::string& before = "") const {
    const std::string out = *this / ".stdout", err = *this / ".stderr";
    const int status =
        std::system(fmt::format("{} {} {} >{} 2>{}", before, program_, in_folder(arguments), out, err).c_str());
    return {WEXITSTATUS(status), read_text(out), read_text(err), arguments};
  }
  /// Starts the program in the background without a desktop. `environment`: "NAME=VALUE …". The program is killed when
  /// the test ends.
  pid_t start(const std::string& arguments, const std::string& environment = "") const {
    const std::string out = *this / ".started_out", err = *this / ".started_err";
    const std::string command = fmt::format("exec env -u DISPLAY -u WAYLAND_DISPLAY {} {} {} <&- >{} 2>{}", environment,
                                            program_, in_folder(arguments), out, err);
    const pid_t child = ::fork();
    if (child != 0) return child;
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
    ::setsid();                          // so that signals of a terminal do not reach it
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // killed when the test is killed
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(127);
  }
  std::string said() const { return read_text(*this / ".started_err"); }
  /// Asks the program to end and waits. The status is -1 if the program did not exit by itself.
  Ran finish(pid_t child, int signal = SIGINT) const {
    ::kill(child, signal);
    int status = 0;
    ::waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(*this / ".started_out"), said(), ""};
  }
  /// Starts the program, sends it `signal` as soon as `begun` returns true, and waits until it ends.
  /// If `begun` does not return true within ten minutes, the test fails.
  Ran interrupted(const std::string& arguments, int signal, const std::function<bool()>& begun) const {
    using namespace std::chrono_literals;
    const pid_t child = start(arguments);
    bool has_begun = false;
    for (int i = 0; i < 60000 && !(has_begun = begun()); ++i) std::this_thread::sleep_for(10ms);
    EXPECT_TRUE(has_begun) << said();
    return finish(child, signal);
  }

 private:
  std::string program_;
};

}  // namespace typodont::test
