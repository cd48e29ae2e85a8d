// Takes touches out of the samples of a hand: the mean of a tenth of a second before the pedal goes down, and only when
// the tip was at rest then. The time before counts, because the foot that presses shakes the hand.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/pose.h"

namespace typodont::calibration {

class StillTouch {
 public:
  struct Limits {
    double window = 0.1;     // s that are averaged
    double radius = 0.3e-3;  // m around the mean that every sample must lie in
  };
  enum class Verdict { kNone, kTaken, kMoved, kTooSoon };  // kTooSoon: the window is not yet full of samples

  explicit StillTouch(const Limits& limits);

  /// One sample; `asked`: somebody pressed a key. Anything but kNone answers the pedal or the key. A pedal answers once
  /// each time it goes down; one that is down at the first sample must come up first. `joints` (rad, six count) are
  /// averaged alike. Never allocates.
  Verdict add(Nanos t, const dvec3& p, double pedal, bool asked, std::span<const double> joints = {}) noexcept;

  const dvec3& point() const noexcept { return mean_; }  // of the last kTaken or kMoved
  /// Of the last kTaken, where every sample came with six.
  bool has_joints() const noexcept { return has_joints_; }
  const std::array<double, 6>& joints() const noexcept { return joints_; }  // rad
  double moved() const noexcept { return moved_; }                          // m, the farthest sample from that point

 private:
  struct Sample {
    Nanos t;
    dvec3 p;
    bool has_joints;
    std::array<double, 6> joints;
  };
  Verdict judge() noexcept;
  const Sample& back(std::size_t age) const noexcept {
    return samples_[(next_ + samples_.size() - 1 - age) % samples_.size()];
  }

  Limits limits_;
  std::vector<Sample> samples_;  // a ring
  std::size_t next_ = 0, count_ = 0;
  bool pedal_down_ = true;
  dvec3 mean_{0};
  bool has_joints_ = false;
  std::array<double, 6> joints_{};
  double moved_ = 0;
};

}  // namespace typodont::calibration
