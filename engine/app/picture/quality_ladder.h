// Chooses the quality level of the pictures: lower while frames take too long, higher when there is time, unless a
// level is fixed. Render thread only.
#pragma once

#include <algorithm>
#include <string_view>

#include "engine/render/quality.h"

namespace typodont {

/// What would give a better picture on this machine.
enum class Remedy { kNone, kGraphicsCard, kSmallerWindow, kFasterCard };

class QualityLadder {
 public:
  /// Index of the level at which a session with a graphics card begins.
  static constexpr std::size_t kCardStep = 1;
  /// `slow`, `quick`: limits of the mean frame time, s. Above `slow` the quality falls; below `quick` it rises. If a
  /// higher level was too slow, the next attempt waits longer. `first`: level at the start.
  explicit QualityLadder(double slow = kSlow, double quick = 1.0 / 90, std::size_t first = kCardStep)
      : slow_(slow), quick_(quick), step_(first), mean_((slow + quick) / 2) {}
  /// Limits for software rendering. A better level can take twice as long: quality rises only at a mean below 1/75 s.
  static QualityLadder for_processor() { return QualityLadder(kSlow, 1.0 / 75, 3); }
  /// `level`: name of a level in render::kQualityLadder.
  static QualityLadder fixed_at(std::string_view level) {
    const auto found = std::find_if(render::kQualityLadder.begin(), render::kQualityLadder.end(),
                                    [&](const render::Quality& q) { return q.name == level; });
    QualityLadder ladder(kSlow, 1.0 / 90, static_cast<std::size_t>(found - render::kQualityLadder.begin()));
    ladder.fixed_ = true;
    return ladder;
  }
  const render::Quality& step() const { return render::kQualityLadder[step_]; }
  // Index of the current level; 0 is the best.
  int place() const { return static_cast<int>(step_); }
  int changes() const { return changes_; }
  bool fixed() const { return fixed_; }
  double slow() const { return slow_; }  // s, mean frame time above which the quality falls
  /// What would improve the picture if its level is worse than kCardStep and not fixed; otherwise kNone. `processor`:
  /// true if the CPU draws. `window`: true if the user can make the picture smaller. `pixels`: shown pixels of an eye.
  Remedy remedy(bool processor, bool window, double pixels) const {
    if (fixed_ || step_ <= kCardStep) return Remedy::kNone;
    if (processor) return Remedy::kGraphicsCard;
    return window && pixels > kSmallWindow ? Remedy::kSmallerWindow : Remedy::kFasterCard;
  }
  /// Takes a frame's drawing time, s. True: the level changed.
  bool frame_took(double seconds) {
    if (fixed_) return false;
    // Ignores the first frames of a new quality level, because they create pipelines and are slow.
    if (fresh_ > 0) return --fresh_, false;
    // Limits the time that a frame contributes to the mean, so that one late frame does not lower the quality.
    mean_ += 0.15 * (std::min(seconds, 2 * slow_) - mean_);
    ++frames_;
    const bool much_too_slow = frames_ >= kHurry && mean_ > 1.4 * slow_;
    if ((much_too_slow || (frames_ >= kSettled && mean_ > slow_)) && step_ + 1 < render::kQualityLadder.size()) {
      if (tried_ && frames_ < kTrial) patience_ = std::min(2 * patience_, kMaxPatience);
      return go(step_ + 1, false);
    }
    if (frames_ >= patience_ && mean_ < quick_ && step_ > 0) return go(step_ - 1, true);
    return false;
  }

 private:
  // Shown pixels of an eye. A card that is too slow for this size is too slow for most windows.
  static constexpr double kSmallWindow = 1280 * 1024;
  // Default of `slow`, s.
  static constexpr double kSlow = 1.0 / 33;
  static constexpr int kFresh = 2, kHurry = 4, kSettled = 12, kTrial = 240, kFirstPatience = 60,
                       /// Longest wait before the quality may rise again, frames.
      kMaxPatience = 7200;

  bool go(std::size_t step, bool up) {
    step_ = step;
    tried_ = up;
    frames_ = 0;
    fresh_ = kFresh;
    mean_ = (slow_ + quick_) / 2;
    ++changes_;
    return true;
  }

  /// Limits of the mean frame time, s. Above `slow_` the quality falls; below `quick_` it rises.
  double slow_, quick_;
  std::size_t step_;
  int frames_ = 0, fresh_ = kFresh, patience_ = kFirstPatience, changes_ = 0;
  bool fixed_ = false;  // true: the level never changes
  bool tried_ = false;  // true: the last change raised the quality
  double mean_;         // s, running mean of the frame time
};

}  // namespace typodont
