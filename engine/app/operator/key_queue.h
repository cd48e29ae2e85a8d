// Queues keys for the pages, which read them once per frame. On a busy computer, several key presses may arrive between
// two frames. Main thread only.
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
  /// Returns the keys for this frame: each key at most once, with its Ctrl or Shift. An emergency stop comes first. If
  /// a key may move the focus, later text, arrows, Enter and Esc are returned only after the focus has moved.
  std::vector<Key> next(bool emergency_stop = false);
  bool empty() const { return waiting_.empty(); }

 private:
  std::deque<Key> waiting_;
  std::array<bool, display::keys::kCount> down_{};  // state of the keys after the last frame
  int frames_until_there_ = 0;
};

}  // namespace typodont
