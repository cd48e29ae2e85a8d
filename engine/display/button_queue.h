// The mouse buttons of a window.
#pragma once

#include <deque>

namespace typodont::display {

/// One button's presses and releases, shown one per look, so that no click is lost on a busy computer. Render thread.
class ButtonQueue {
 public:
  /// Adds a press (true) or a release (false).
  void add(bool down) { waiting_.push_back(down); }
  /// State after the next event, if any.
  bool next() {
    if (!waiting_.empty()) {
      down_ = waiting_.front();
      waiting_.pop_front();
    }
    return down_;
  }

 private:
  std::deque<bool> waiting_;
  bool down_ = false;
};

}  // namespace typodont::display
