// Runs this program in a separate process, for work whose failure must not affect the window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"

namespace typodont {

/// Niceness (scheduling priority) of a process that gets the processor only while no other process needs it.
inline constexpr int kLowestPriority = 19;

/// Runs `typodont ARGUMENTS` and waits for its end. Returns its output, and passes its progress to `progress`. If the
/// user cancels, the process is asked to end; if it does not end, it is killed. `nice`: niceness of the process, 0 to
/// 19. Throws Cancelled if the user cancels. Throws RunFailure with the process's last message if the process fails and
/// has written no output.
std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice = 0);

/// Programs that were started and run independently of the window. Their failures are detected. Main thread only.
class Started {
 public:
  /// Opens a file or folder with the desktop's default program.
  void open(const std::string& file);
  /// Starts `typodont ARGUMENTS` without waiting for its end.
  void self(const std::vector<std::string>& arguments);

  struct Failed {
    std::string file;   // the file that could not be opened; empty if a process of this program failed
    std::string words;  // last message of the failed program
  };
  /// Checks the started programs. Returns a program that failed since the last call; empty if none failed.
  std::optional<Failed> look();

 private:
  struct One {
    int process = -1;
    int said = -1;  // file descriptor of the process's messages, which are stored in memory
    std::string file;
  };
  void start(std::vector<std::string> words, const std::string& file);
  std::vector<One> running_;
};

}  // namespace typodont
