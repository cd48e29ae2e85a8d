// The mouse buttons of a window.
#pragma once

#include <deque>

namespace typodont::display {

/// The presses and releases of one mouse button. On a busy computer, several of them arrive before the program looks
/// again. The queue then shows the program one after the other, so that a click shorter than a frame, and a click that
/// follows a drag at once, are not lost. Render thread only.
class ButtonQueue {
 public:
  /// Adds a press (true) or a release (false).
  void add(bool down) { waiting_.push_back(down); }
  /// Returns true if the button is down after the next press or release. Without a new one, the state does not change.
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
