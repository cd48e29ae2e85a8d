// Steps down the ladder of quality while frames take too long, and back up when there is room. Drawing thread.
#pragma once

#include <algorithm>

#include "engine/render/quality.h"

namespace typodont {

class QualityLadder {
 public:
  /// `slow`: frames that take longer than this, s, step down; `quick`: shorter ones step up, later and later where the
  /// step above proved too slow before. A little less than a thirtieth of a second, so that thirty a second are
  /// reached.
  explicit QualityLadder(double slow = kSlow, double quick = 1.0 / 90, std::size_t first = 1)
      : slow_(slow), quick_(quick), step_(first), mean_((slow + quick) / 2) {}
  /// Where a processor draws: from about what it is quick enough for, and up where a frame leaves room for the next
  /// step's, which takes up to twice as long.
  static QualityLadder for_processor() { return QualityLadder(kSlow, 1.0 / 75, 3); }
  const render::Quality& step() const { return render::kQualityLadder[step_]; }
  int place() const { return static_cast<int>(step_); }  // 0: best
  int changes() const { return changes_; }
  double slow() const { return slow_; }  // s
  /// True when the step changed. Only frames that were drawn count.
  bool frame_took(double seconds) {
    // The first of a step make its pipelines, which no later one does.
    if (fresh_ > 0) return --fresh_, false;
    // One frame that was kept waiting is none of the picture's doing.
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
  static constexpr double kSlow = 1.0 / 33;  // s
  static constexpr int kFresh = 2, kHurry = 4, kSettled = 12, kTrial = 240, kFirstPatience = 60,
                       kMostPatience = 7200;  // frames

  bool go(std::size_t step, bool up) {
    step_ = step;
    tried_ = up;
    frames_ = 0;
    fresh_ = kFresh;
    mean_ = (slow_ + quick_) / 2;
    ++changes_;
    return true;
  }

  double slow_, quick_;  // s
  std::size_t step_;
  int frames_ = 0, fresh_ = kFresh, patience_ = kFirstPatience, changes_ = 0;
  bool tried_ = false;  // the last change was up
  double mean_;         // s
};

}  // namespace typodont
