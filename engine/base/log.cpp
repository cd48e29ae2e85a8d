#include "engine/base/log.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace typodont::log {

void write(std::string_view level, std::string_view text) {
  fmt::print(stderr, "{}{}\n", level, text);
}

Progress::Progress(std::string_view what) : what_(what), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (terminal_ && shown_ >= 0) fmt::print(stderr, "\n");
}

void Progress::update(double fraction) {
  const int percent = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * 100.0);
  const int step = terminal_ ? percent : percent / 10 * 10;
  if (step == shown_) return;
  shown_ = step;
  if (terminal_) {
    fmt::print(stderr, "\r{}: {:3d} %", what_, step);
    std::fflush(stderr);
  } else {
    fmt::print(stderr, "{}: {} %\n", what_, step);
  }
}

}  // namespace typodont::log
