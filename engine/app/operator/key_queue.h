// What was done on the keyboard, handed to the pages frame by frame. A page sees the state of the keys once a frame; on
// a busy computer much may be done between two frames, and none of it is lost or comes out of its order. Main thread.
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
  /// For one frame: no key more than once, a pressed key with the Ctrl or Shift it was pressed with, and no text and no
  /// arrow, Enter or Esc after a key that may lead elsewhere, until it has. Where Esc and Space are the emergency
  /// stop, they overtake everything.
  std::vector<Key> next(bool emergency_stop = false);
  bool empty() const { return waiting_.empty(); }

 private:
  std::deque<Key> waiting_;
  std::array<bool, display::keys::kCount> down_{};  // after the last frame
  int frames_until_there_ = 0;
};

}  // namespace typodont
