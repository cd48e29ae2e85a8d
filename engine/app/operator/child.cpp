#include "engine/app/operator/child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include "engine/base/error.h"

namespace typodont {

namespace {

constexpr int kChildPoll = 50;  // ms, time between two checks for a cancellation
// Time from the request to end until the process is killed, ms.
constexpr int kEndPatience = 3000;

/// Starts the program words[0]. `files`: its input, output and messages; −1: the file of this process. Returns the
/// process; negative: it cannot be started.
pid_t start_process(std::vector<std::string> words, const std::array<int, 3>& files, int nice) {
  std::vector<char*> line;
  for (std::string& word : words) line.push_back(word.data());
  line.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0) return child;
  for (int i = 0; i < 3; ++i)
    if (files[static_cast<std::size_t>(i)] >= 0) dup2(files[static_cast<std::size_t>(i)], i);
  if (nice > 0) setpriority(PRIO_PROCESS, 0, nice);
  execvp(line[0], line.data());
  _exit(127);
}

std::vector<std::string> self_with(const std::vector<std::string>& arguments) {
  std::error_code code;
  std::vector<std::string> words{std::filesystem::read_symlink("/proc/self/exe", code).string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

/// Fraction from the last message such as "film: 30 %", 0 to 1; 0 if there is none.
double fraction_in(const std::string& messages) {
  const std::size_t sign = messages.rfind(" %\n");
  if (sign == std::string::npos) return 0;
  const std::size_t before = messages.rfind(' ', sign - 1);
  return std::clamp(std::atof(messages.c_str() + (before == std::string::npos ? 0 : before + 1)) / 100, 0.0, 0.99);
}

/// A file in memory, at its beginning. −1: there is none.
int file_in_memory(const std::string& bytes) {
  const int file = memfd_create("input", MFD_CLOEXEC);
  if (file < 0) return -1;
  const bool whole = write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  if (whole && lseek(file, 0, SEEK_SET) == 0) return file;
  close(file);
  return -1;
}

}  // namespace

std::string last_line(std::string_view text) {
  while (text.ends_with('\n')) text.remove_suffix(1);
  return std::string(text.substr(text.rfind('\n') + 1));
}

std::string run_program(const std::vector<std::string>& words, Progress& progress, const ChildOptions& options) {
  const int input = file_in_memory(options.input);
  if (input < 0) throw RunFailure("cannot start " + words[0]);
  struct Closed {
    int file;
    ~Closed() { close(file); }
  } closed{input};
  std::array<std::array<int, 2>, 2> ends{};  // pipes for the process's output and messages
  if (pipe2(ends[0].data(), O_CLOEXEC) != 0) throw RunFailure("cannot start " + words[0]);
  if (pipe2(ends[1].data(), O_CLOEXEC) != 0) {
    close(ends[0][0]), close(ends[0][1]);
    throw RunFailure("cannot start " + words[0]);
  }
  const pid_t child = start_process(words, {input, ends[0][1], ends[1][1]}, options.nice);
  close(ends[0][1]), close(ends[1][1]);
  struct Ended {  // its destructor ends the process, however the function is left
    pid_t child;
    std::array<int, 2> from;
    ~Ended() {
      for (const int one : from) close(one);
      if (child <= 0) return;
      kill(child, SIGINT);  // the process ends and removes its partial files
      for (int i = 0; i < kEndPatience / kChildPoll; ++i) {
        if (waitpid(child, nullptr, WNOHANG) == child) return;
        poll(nullptr, 0, kChildPoll);
      }
      kill(child, SIGKILL);  // the process did not end in time
      waitpid(child, nullptr, 0);
    }
  } ended{child, {ends[0][0], ends[1][0]}};
  if (child < 0) throw RunFailure("cannot start " + words[0]);
  std::array<std::string, 2> said;
  std::array<pollfd, 2> waiting{pollfd{ended.from[0], POLLIN, 0}, pollfd{ended.from[1], POLLIN, 0}};
  double fraction = 0;
  std::size_t told = 0;  // bytes of output whose lines on_line has got
  while (waiting[0].fd >= 0 || waiting[1].fd >= 0) {
    progress.at(fraction);
    if (poll(waiting.data(), waiting.size(), kChildPoll) <= 0) continue;
    for (std::size_t i = 0; i < 2; ++i) {
      if (waiting[i].fd < 0 || waiting[i].revents == 0) continue;
      std::array<char, 4096> piece;
      const ssize_t n = read(waiting[i].fd, piece.data(), piece.size());
      if (n <= 0)
        waiting[i].fd = -1;
      else
        said[i].append(piece.data(), static_cast<std::size_t>(n));
    }
    fraction = std::max(fraction, fraction_in(said[1]));
    for (std::size_t end; options.on_line && (end = said[0].find('\n', told)) != std::string::npos; told = end + 1)
      options.on_line(std::string_view(said[0]).substr(told, end - told));
  }
  int status = 0;
  waitpid(child, &status, 0);  // returns soon, because the process has closed its output
  ended.child = 0;
  if ((WIFEXITED(status) && WEXITSTATUS(status) == 0) || !said[0].empty()) return said[0];
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127 && said[1].empty()) throw NotStarted("cannot start " + words[0]);
  throw RunFailure(last_line(said[1]));
}

std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice) {
  return run_program(self_with(arguments), progress, {.nice = nice});
}

void Started::start(const std::vector<std::string>& words, const std::string& file) {
  // The process writes its messages to memory. A pipe would break when the window closes, which would end the process.
  const int said = memfd_create("messages", MFD_CLOEXEC);
  const pid_t child = start_process(words, {-1, -1, said}, 0);
  if (child > 0)
    running_.push_back({child, said, file});
  else if (said >= 0)
    close(said);
}

void Started::open(const std::string& file) {
  start({"xdg-open", file}, file);
}

void Started::self(const std::vector<std::string>& arguments) {
  start(self_with(arguments), "");
}

std::optional<Started::Failed> Started::look() {
  for (auto one = running_.begin(); one != running_.end(); ++one) {
    int status = 0;
    if (waitpid(one->process, &status, WNOHANG) == 0) continue;
    Failed failed{one->file, ""};
    std::array<char, 4096> last{};
    const off_t size = one->said >= 0 ? lseek(one->said, 0, SEEK_END) : 0;
    const off_t from = std::max<off_t>(0, size - static_cast<off_t>(last.size()));
    const ssize_t n = size > 0 ? pread(one->said, last.data(), last.size(), from) : 0;
    if (n > 0) failed.words = last_line({last.data(), static_cast<std::size_t>(n)});
    if (one->said >= 0) close(one->said);
    running_.erase(one);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return failed;
    return std::nullopt;  // this process ended without error; the next call checks the others
  }
  return std::nullopt;
}

}  // namespace typodont
