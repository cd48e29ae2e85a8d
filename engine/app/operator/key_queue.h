// A page reads the keys once per frame. On a busy computer several may come between: they are queued in order. Main
// thread only.
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
  /// Each key once per frame, with its Ctrl or Shift. After a key that may move the focus, text, arrows, Enter and Esc
  /// wait for it. An emergency stop goes first.
  std::vector<Key> next(bool emergency_stop = false);
  bool empty() const { return waiting_.empty(); }

 private:
  std::deque<Key> waiting_;
  std::array<bool, display::keys::kCount> down_{};  // state of the keys after the last frame
  int frames_until_there_ = 0;
};

}  // namespace typodont
