// Passes keyboard input to the pages frame by frame. A page reads the state of the keys once per frame. On a busy
// computer, the user may press several keys between two frames. The queue stores them all in order. Main thread only.
#pragma once

#include <array>
#include <deque>
#include <span>
#include <vector>

#include "engine/display/keys.h"
#include "engine/display/output.h"

namespace typodont {

class KeyQueue {
 public:
  using Key = display::UserInput::Key;

  void add(std::span<const Key> done);
  /// Returns the keys for one frame. Each key occurs at most once, together with its Ctrl or Shift. If one of the keys
  /// may move the focus, the following text, arrow keys, Enter and Esc are kept for later frames until the focus has
  /// moved. If Esc and Space act as emergency stop, they are returned before all other keys.
  std::vector<Key> next(bool emergency_stop = false);
  bool empty() const { return waiting_.empty(); }

 private:
  std::deque<Key> waiting_;
  std::array<bool, display::keys::kCount> down_{};  // state of the keys after the last frame
  int frames_until_there_ = 0;
};

}  // namespace typodont
