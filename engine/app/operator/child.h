// This program once more, beside the window: what must not take the window with it when it fails.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"

namespace typodont {

/// Niceness of a program that runs only while no other wants the processor.
inline constexpr int kLowestPriority = 19;

/// Runs `typodont ARGUMENTS` to its end and returns what it printed; how far it says it is goes to `progress`.
/// Cancelled, it is asked to end, and made to. `nice`: its niceness, 0 to 19. Throws Cancelled; RunFailure with the
/// program's last message where it fails without an answer.
std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice = 0);

/// Programs that were started and go on by themselves; of one that fails it is known. Main thread.
class Started {
 public:
  /// Opens a file or folder with what the desktop has for it.
  void open(const std::string& file);
  /// Starts `typodont ARGUMENTS`.
  void self(const std::vector<std::string>& arguments);

  struct Failed {
    std::string file;   // that could not be opened; empty: it was this program
    std::string words;  // the last it said
  };
  /// One that has ended with a failure since the last look.
  std::optional<Failed> look();

 private:
  struct One {
    int process = -1;
    int said = -1;  // its messages, in memory
    std::string file;
  };
  void start(std::vector<std::string> words, const std::string& file);
  std::vector<One> running_;
};

}  // namespace typodont
