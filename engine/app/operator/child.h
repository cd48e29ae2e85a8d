// Runs this program as a separate process beside the window, for work whose failure must not affect the window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"

namespace typodont {

/// Niceness of a program that runs only while no other needs the processor.
inline constexpr int kLowestPriority = 19;

/// Runs `typodont ARGUMENTS` to its end and returns its output; the progress that it reports goes to `progress`. On
/// cancellation it is asked to end, then killed. `nice`: its niceness, 0 to 19. Throws Cancelled, or RunFailure with
/// the program's last message if it fails without output.
std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice = 0);

/// Programs that were started and run independently; detects failures. Main thread.
class Started {
 public:
  /// Opens a file or folder with the desktop's program for it.
  void open(const std::string& file);
  /// Starts `typodont ARGUMENTS`.
  void self(const std::vector<std::string>& arguments);

  struct Failed {
    std::string file;   // the file that could not be opened; empty: this program failed
    std::string words;  // its last message
  };
  /// A program that failed since the last call, if there is one.
  std::optional<Failed> look();

 private:
  struct One {
    int process = -1;
    int said = -1;  // descriptor of its messages in memory
    std::string file;
  };
  void start(std::vector<std::string> words, const std::string& file);
  std::vector<One> running_;
};

}  // namespace typodont
