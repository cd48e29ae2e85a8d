// Runs programs in separate processes, for work whose failure must not affect the window.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/progress.h"

namespace typodont {

/// Scheduling priority (nice) of work that gets the processor only while no other work needs it.
inline constexpr int kLowestPriority = 19;

/// Thrown if there is no such program.
class NotStarted : public RunFailure {
 public:
  using RunFailure::RunFailure;
};

/// The last line of a process's output or messages, without its end.
std::string last_line(std::string_view text);

struct ChildOptions {
  int nice = 0;                                             // 0 to 19
  std::string input;                                        // standard input, which no other process sees
  std::function<void(std::string_view line)> on_line = {};  // called for each line of output, in the caller's thread
};
/// Runs the program words[0] to its end, like run_self().
std::string run_program(const std::vector<std::string>& words, Progress& progress, const ChildOptions& options);

/// Runs `typodont ARGUMENTS` to its end and returns its output. To cancel, asks the process to end, then kills it.
/// `nice`: 0 to 19. Throws Cancelled, or RunFailure with the last message of a process that fails without output.
std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice = 0);

/// Starts programs that outlive the window, and detects their failures. Main thread only.
class Started {
 public:
  /// Opens the file with the desktop's default program.
  void open(const std::string& file);
  /// Starts `typodont ARGUMENTS` without waiting for it.
  void self(const std::vector<std::string>& arguments);

  struct Failed {
    std::string file;   // file that could not be opened; empty: this program failed
    std::string words;  // last message of the failed program
  };
  /// A program that failed since the last call.
  std::optional<Failed> look();

 private:
  struct One {
    int process = -1;
    int said = -1;  // file descriptor of the child's messages, a file in memory
    std::string file;
  };
  void start(const std::vector<std::string>& words, const std::string& file);
  std::vector<One> running_;
};

}  // namespace typodont
