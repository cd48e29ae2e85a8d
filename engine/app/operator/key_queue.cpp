#include "engine/app/operator/key_queue.h"

namespace typodont {

namespace keys = display::keys;

namespace {
// ImGui moves the focus in the frame after the one that asked for it, and there a field does not take text yet.
constexpr int kFramesUntilText = 3;
}  // namespace

void KeyQueue::add(std::span<const Key> done) {
  waiting_.insert(waiting_.end(), done.begin(), done.end());
}

std::vector<KeyQueue::Key> KeyQueue::next() {
  std::vector<Key> frame;
  std::array<bool, keys::kCount> seen{};
  bool pressed = false;
  if (frames_until_text_ > 0) --frames_until_text_;
  while (!waiting_.empty()) {
    const Key key = waiting_.front();
    if (key.typed != 0) {
      if (frames_until_text_ > 0) break;
      frame.push_back(key);
    } else if (key.code >= 0 && key.code < keys::kCount) {
      const auto code = static_cast<std::size_t>(key.code);
      if (down_[code] != key.down) {  // else it repeats, which the pages do themselves
        const bool modifies = key.code >= keys::kLeftShift;
        if (seen[code] || (modifies && pressed)) break;
        seen[code] = true;
        down_[code] = key.down;
        const bool control = down_[keys::kLeftControl] || down_[keys::kRightControl];
        pressed = pressed || (key.down && !modifies);
        if (key.down && !modifies && (control || key.code >= keys::kEscape)) frames_until_text_ = kFramesUntilText;
        frame.push_back(key);
      }
    }
    waiting_.pop_front();
  }
  return frame;
}

}  // namespace typodont
