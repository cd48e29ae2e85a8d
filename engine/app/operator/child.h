// This program in its own process, for work whose failure must not reach the window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"

namespace typodont {

/// gets the processor only while nobody else needs it
inline constexpr int kLowestPriority = 19;

/// `typodont ARGUMENTS` to its end; returns its output. Cancelling ends it, then kills it. `nice`: 0 to 19. Throws
/// Cancelled, or RunFailure with its last message if it fails without output.
std::string run_self(const std::vector<std::string>& arguments, Progress& progress, int nice = 0);

/// Programs that outlive the window. Failures are detected. Main thread only.
class Started {
 public:
  /// With the desktop's default program.
  void open(const std::string& file);
  /// `typodont ARGUMENTS`, without waiting.
  void self(const std::vector<std::string>& arguments);

  struct Failed {
    std::string file;   // that could not be opened; empty: this program failed
    std::string words;  // last message of the failed program
  };
  /// A program that failed since the last call.
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
