#include "engine/app/operator/child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "engine/base/error.h"

namespace typodont {

namespace {

constexpr int kLook = 50;  // ms between looks at the wish to stop

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> result;
  for (std::string& word : words) result.push_back(word.data());
  result.push_back(nullptr);
  return result;
}

std::vector<std::string> self_with(const std::vector<std::string>& arguments) {
  std::error_code code;
  std::vector<std::string> words{std::filesystem::read_symlink("/proc/self/exe", code).string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

/// The grandchild is nobody's to wait for.
void start(std::vector<std::string> words) {
  const std::vector<char*> line = pointers(words);
  const pid_t first = fork();
  if (first == 0) {
    if (fork() == 0) {
      execvp(line[0], line.data());
      _exit(127);
    }
    _exit(0);
  }
  if (first > 0) waitpid(first, nullptr, 0);
}

}  // namespace

std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice) {
  std::vector<std::string> words = self_with(arguments);
  const std::vector<char*> line = pointers(words);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw RunFailure("cannot start " + words[0]);
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    if (const int nothing = open("/dev/null", O_WRONLY); nothing >= 0) dup2(nothing, STDERR_FILENO);
    setpriority(PRIO_PROCESS, 0, nice);
    execv(line[0], line.data());
    _exit(127);
  }
  close(ends[1]);
  struct Ended {  // in every case
    pid_t child;
    int from;
    ~Ended() {
      close(from);
      if (child <= 0) return;
      kill(child, SIGKILL);  // does nothing to one that has ended
      waitpid(child, nullptr, 0);
    }
  } ended{child, ends[0]};
  if (child < 0) throw RunFailure("cannot start " + words[0]);
  std::string out;
  std::array<char, 4096> piece;
  while (true) {
    progress.at(0.5);
    pollfd waiting{ends[0], POLLIN, 0};
    if (poll(&waiting, 1, kLook) <= 0) continue;
    const ssize_t n = read(ends[0], piece.data(), piece.size());
    if (n <= 0) break;
    out.append(piece.data(), static_cast<std::size_t>(n));
  }
  waitpid(child, nullptr, 0);  // it has closed its output: it is about to end
  ended.child = 0;
  return out;
}

void start_self(const std::vector<std::string>& arguments) {
  start(self_with(arguments));
}

void open_with_desktop(const std::string& file) {
  start({"xdg-open", file});
}

}  // namespace typodont
