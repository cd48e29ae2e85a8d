#include "calibration/still_touch.h"

#include <algorithm>

namespace typodont::calibration {

namespace {
constexpr std::size_t kSamples = 4096;  // number of stored samples: 0.1 s at 40 kHz
constexpr std::size_t kFewest = 4;
// The pedal counts as pressed above kDown, and as released below kUp (hysteresis).
constexpr double kDown = 0.5, kUp = 0.3;
}  // namespace

StillTouch::StillTouch(const Limits& limits) : limits_(limits), samples_(kSamples) {}

StillTouch::Verdict StillTouch::add(Nanos t, const dvec3& p, double pedal, bool asked,
                                    std::span<const double> joints) noexcept {
  // If time does not increase, earlier samples are dropped.
  if (!is_finite(p) || (count_ > 0 && t <= back(0).t)) count_ = 0;
  if (is_finite(p)) {
    Sample& sample = samples_[next_];
    sample.t = t, sample.p = p, sample.has_joints = joints.size() >= sample.joints.size();
    if (sample.has_joints) std::copy_n(joints.begin(), sample.joints.size(), sample.joints.begin());
    next_ = (next_ + 1) % samples_.size();
    count_ = std::min(count_ + 1, samples_.size());
  }
  const bool pressed = !pedal_down_ && pedal > kDown;
  if (pedal > kDown) pedal_down_ = true;
  if (pedal < kUp) pedal_down_ = false;
  return pressed || asked ? judge() : Verdict::kNone;
}

StillTouch::Verdict StillTouch::judge() noexcept {
  if (count_ == 0) return Verdict::kTooSoon;
  const Nanos begin = back(0).t - from_seconds(limits_.window);
  std::size_t used = 0;
  while (used < count_ && back(used).t >= begin) ++used;
  // The averaged window is complete when one sample is at least as old as its begin.
  if (used < kFewest || (used == count_ && back(used - 1).t > begin)) return Verdict::kTooSoon;
  // Sums the samples' differences from the newest one, so that the mean of equal samples is exact.
  const dvec3 origin = back(0).p;
  dvec3 sum(0);
  for (std::size_t i = 0; i < used; ++i) sum += back(i).p - origin;
  mean_ = origin + sum / static_cast<double>(used);
  has_joints_ = true;
  joints_ = {};
  for (std::size_t i = 0; i < used; ++i) {
    has_joints_ = has_joints_ && back(i).has_joints;
    for (std::size_t k = 0; k < joints_.size(); ++k) joints_[k] += back(i).joints[k] - back(0).joints[k];
  }
  for (std::size_t k = 0; k < joints_.size(); ++k)
    joints_[k] = back(0).joints[k] + joints_[k] / static_cast<double>(used);
  moved_ = 0;
  for (std::size_t i = 0; i < used; ++i) moved_ = std::max(moved_, glm::length(back(i).p - mean_));
  return moved_ <= limits_.radius ? Verdict::kTaken : Verdict::kMoved;
}

}  // namespace typodont::calibration
