#include "engine/app/operator/key_queue.h"

#include <algorithm>

namespace typodont {

namespace keys = display::keys;

namespace {
// Number of frames that ImGui needs to move the focus or to open a list. Only after these frames, fields accept text,
// and lists accept arrow keys.
constexpr int kFocusFrames = 3;

/// True if ImGui sends this key to the focused element.
bool acts_on_focus(int code) {
  return code >= keys::kEscape && code <= keys::kEnd && code != keys::kInsert;
}
}  // namespace

void KeyQueue::add(std::span<const Key> done) {
  waiting_.insert(waiting_.end(), done.begin(), done.end());
}

std::vector<KeyQueue::Key> KeyQueue::next(bool emergency_stop) {
  std::vector<Key> frame;
  std::array<bool, keys::kCount> seen{};
  bool pressed = false;
  if (frames_until_there_ > 0) --frames_until_there_;
  if (emergency_stop) {
    const auto stop = std::find_if(waiting_.begin(), waiting_.end(),
                                   [](const Key& k) { return (k.code == keys::kEscape || k.code == ' ') && k.down; });
    if (stop != waiting_.end()) {
      std::rotate(waiting_.begin(), stop, stop + 1);
      frames_until_there_ = 0;
    }
  }
  while (!waiting_.empty()) {
    const Key key = waiting_.front();
    if (key.typed != 0) {
      if (frames_until_there_ > 0) break;
      frame.push_back(key);
    } else if (key.code >= 0 && key.code < keys::kCount) {
      const auto code = static_cast<std::size_t>(key.code);
      // Skips repeated key events, because the pages repeat keys themselves.
      if (down_[code] != key.down) {
        const bool modifies = key.code >= keys::kLeftShift;
        if (seen[code] || (modifies && pressed) || (key.down && frames_until_there_ > 0 && acts_on_focus(key.code)))
          break;
        seen[code] = true;
        down_[code] = key.down;
        const bool control = down_[keys::kLeftControl] || down_[keys::kRightControl];
        pressed = pressed || (key.down && !modifies);
        if (key.down && !modifies && (control || key.code >= keys::kEscape)) frames_until_there_ = kFocusFrames;
        frame.push_back(key);
      }
    }
    waiting_.pop_front();
  }
  return frame;
}

}  // namespace typodont
