// Passes keyboard input to the pages frame by frame. A page reads the state of the keys once per frame. On a busy
// computer several keys may be pressed between two frames; the queue keeps them all, in order. Main thread.
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
  /// The keys for one frame: each key at most once, a pressed key with its Ctrl or Shift, and no text, arrow, Enter or
  /// Esc after a key that may move the focus until that has happened. If Esc and Space are the emergency stop, they
  /// come before everything else.
  std::vector<Key> next(bool emergency_stop = false);
  bool empty() const { return waiting_.empty(); }

 private:
  std::deque<Key> waiting_;
  std::array<bool, display::keys::kCount> down_{};  // state after the last frame
  int frames_until_there_ = 0;
};

}  // namespace typodont
