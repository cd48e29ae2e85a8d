// Chooses the quality of the picture. Lowers it while frames take too long, and raises it when there is enough time,
// unless the user has chosen a fixed level. Render thread only.
#pragma once

#include <algorithm>
#include <string_view>

#include "engine/render/quality.h"

namespace typodont {

class QualityLadder {
 public:
  /// `slow`, `quick`: s. If the running mean of the frame times is longer than `slow`, the quality is lowered; if it is
  /// shorter than `quick`, the quality is raised. If a raised quality proves too slow, the wait before the next raise
  /// becomes longer. The default of `slow` is a little less than 1/30 s, so that 30 frames per second are reached.
  /// `first`: quality level at the start.
  explicit QualityLadder(double slow = kSlow, double quick = 1.0 / 90, std::size_t first = 1)
      : slow_(slow), quick_(quick), step_(first), mean_((slow + quick) / 2) {}
  /// Makes a ladder for software rendering, which starts at a quality that a CPU can draw. A frame of the next better
  /// quality takes up to twice as long. So the quality is raised only if the mean time of a frame is less than 1/75 s.
  static QualityLadder for_processor() { return QualityLadder(kSlow, 1.0 / 75, 3); }
  /// Makes a ladder that stays at the level with this name. `level` must be a name in render::kQualityLadder.
  static QualityLadder fixed_at(std::string_view level) {
    const auto found = std::find_if(render::kQualityLadder.begin(), render::kQualityLadder.end(),
                                    [&](const render::Quality& q) { return q.name == level; });
    QualityLadder ladder(kSlow, 1.0 / 90, static_cast<std::size_t>(found - render::kQualityLadder.begin()));
    ladder.fixed_ = true;
    return ladder;
  }
  const render::Quality& step() const { return render::kQualityLadder[step_]; }
  // returns the index of the present quality level; 0 is the best
  int place() const { return static_cast<int>(step_); }
  int changes() const { return changes_; }
  bool fixed() const { return fixed_; }
  double slow() const { return slow_; }  // returns the time (s) of a frame above which the quality is lowered
  /// Evaluates the time of a frame. Returns true if the level changed. Call it only for frames that were drawn.
  bool frame_took(double seconds) {
    if (fixed_) return false;
    // The first frames of a quality level are not timed, because they include the creation of its graphics pipelines.
    if (fresh_ > 0) return --fresh_, false;
    // A frame's time is limited before it is added to the mean. So one very late frame alone does not lower the
    // quality.
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
  // s, default of `slow`: if the mean time of a frame is longer than this, the quality is lowered
  static constexpr double kSlow = 1.0 / 33;
  static constexpr int kFresh = 2, kHurry = 4, kSettled = 12, kTrial = 240, kFirstPatience = 60,
                       /// longest wait before the quality is raised again, as a number of frames
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

  /// s; if the mean time of a frame is longer than slow_, the quality is lowered; if it is shorter than quick_, the
  /// quality is raised
  double slow_, quick_;
  std::size_t step_;
  int frames_ = 0, fresh_ = kFresh, patience_ = kFirstPatience, changes_ = 0;
  bool fixed_ = false;  // true: the level never changes
  bool tried_ = false;  // true: the last change of the level raised the quality
  double mean_;         // s, running mean of the time of a frame
};

}  // namespace typodont
