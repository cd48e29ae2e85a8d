// The mouse buttons of a window.
#pragma once

#include <deque>

namespace typodont::display {

/// Presses and releases of one button. Each call of next() takes one event, so that no click is lost if a busy computer
/// polls rarely. Render thread only.
class ButtonQueue {
 public:
  /// Adds a press (true) or a release (false).
  void add(bool down) { waiting_.push_back(down); }
  /// Takes the next event, if there is one, and returns whether the button is down.
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
