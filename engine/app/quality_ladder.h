// Steps down the ladder of quality while frames take too long, and back up when there is room. Drawing thread.
#pragma once

#include "engine/render/quality.h"

namespace typodont {

class QualityLadder {
 public:
  /// `slow`: frames that take longer than this, s, step down; `quick`: shorter ones step up.
  explicit QualityLadder(double slow = 1.0 / 30, double quick = 1.0 / 150, std::size_t first = 1)
      : slow_(slow), quick_(quick), step_(first), mean_((slow + quick) / 2) {}
  const render::Quality& step() const { return render::kQualityLadder[step_]; }
  /// True when the step changed. Only frames that were drawn count.
  bool frame_took(double seconds) {
    mean_ += 0.15 * (seconds - mean_);
    if (++frames_ < 12) return false;
    const std::size_t before = step_;
    if (mean_ > slow_ && step_ + 1 < render::kQualityLadder.size()) ++step_;
    if (mean_ < quick_ && step_ > 0) --step_;
    if (step_ == before) return false;
    frames_ = 0;
    mean_ = (slow_ + quick_) / 2;
    return true;
  }

 private:
  double slow_, quick_;  // s
  std::size_t step_;
  int frames_ = 0;
  double mean_;  // s
};

}  // namespace typodont
