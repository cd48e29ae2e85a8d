// Lower quality while frames take too long, higher when there is time, unless a level is fixed. Render thread only.
#pragma once

#include <algorithm>
#include <string_view>

#include "engine/render/quality.h"

namespace typodont {

class QualityLadder {
 public:
  /// s of running mean: lower above `slow` (default: 30 frames per second), higher below `quick`. After a failed raise
  /// the next one waits longer. `first`: level at the start.
  explicit QualityLadder(double slow = kSlow, double quick = 1.0 / 90, std::size_t first = 1)
      : slow_(slow), quick_(quick), step_(first), mean_((slow + quick) / 2) {}
  /// For software rendering. The next better level takes up to twice as long, so it needs a mean below 1/75 s.
  static QualityLadder for_processor() { return QualityLadder(kSlow, 1.0 / 75, 3); }
  /// `level`: of render::kQualityLadder.
  static QualityLadder fixed_at(std::string_view level) {
    const auto found = std::find_if(render::kQualityLadder.begin(), render::kQualityLadder.end(),
                                    [&](const render::Quality& q) { return q.name == level; });
    QualityLadder ladder(kSlow, 1.0 / 90, static_cast<std::size_t>(found - render::kQualityLadder.begin()));
    ladder.fixed_ = true;
    return ladder;
  }
  const render::Quality& step() const { return render::kQualityLadder[step_]; }
  // 0 is the best
  int place() const { return static_cast<int>(step_); }
  int changes() const { return changes_; }
  bool fixed() const { return fixed_; }
  double slow() const { return slow_; }  // s, above which quality falls
  /// True: the level changed. Only for drawn frames.
  bool frame_took(double seconds) {
    if (fixed_) return false;
    // The first frames of a level create pipelines.
    if (fresh_ > 0) return --fresh_, false;
    // Limited, so that one late frame does not lower the quality.
    mean_ += 0.15 * (std::min(seconds, 2 * slow_) - mean_);
    ++frames_;
    const bool much_too_slow = frames_ >= kHurry && mean_ > 1.4 * slow_;
    if ((much_too_slow || (frames_ >= kSettled && mean_ > slow_)) && step_ + 1 < render::kQualityLadder.size()) {
      if (tried_ && frames_ < kTrial) patience_ = std::min(2 * patience_, kMostPatience);
      return go(step_ + 1, false);
    }
    if (frames_ >= patience_ && mean_ < quick_ && step_ > 0) return go(step_ - 1, true);
    return false;
  }

 private:
  // s, default of `slow`
  static constexpr double kSlow = 1.0 / 33;
  static constexpr int kFresh = 2, kHurry = 4, kSettled = 12, kTrial = 240, kFirstPatience = 60,
                       /// frames, longest wait for a raise
      kMostPatience = 7200;

  bool go(std::size_t step, bool up) {
    step_ = step;
    tried_ = up;
    frames_ = 0;
    fresh_ = kFresh;
    mean_ = (slow_ + quick_) / 2;
    ++changes_;
    return true;
  }

  /// s, means for lower and higher quality
  double slow_, quick_;
  std::size_t step_;
  int frames_ = 0, fresh_ = kFresh, patience_ = kFirstPatience, changes_ = 0;
  bool fixed_ = false;  // true: the level never changes
  bool tried_ = false;  // the last change raised the quality
  double mean_;         // s, running
};

}  // namespace typodont
