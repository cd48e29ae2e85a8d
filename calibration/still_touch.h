// Takes a touch: the mean position in the tenth of a second before the pedal was pressed, if the tip was at rest. The
// time before is used because pressing shakes the hand.
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
    double window = 0.1;     // s, length of the averaged interval before the pedal is pressed
    double radius = 0.3e-3;  // m, largest distance of a sample from the mean of a tip at rest
  };
  enum class Verdict { kNone, kTaken, kMoved, kTooSoon };  // kTooSoon: the window does not yet contain enough samples

  explicit StillTouch(const Limits& limits);

  /// Adds a sample. Returns a verdict when the pedal is pressed or `asked` is true, otherwise kNone. A pedal that is
  /// pressed at the start must first be released. `joints` (rad, six or none) are averaged too.
  Verdict add(Nanos t, const dvec3& p, double pedal, bool asked, std::span<const double> joints = {}) noexcept;

  // returns the mean position (m) of the tip at the last touch with the verdict kTaken or kMoved
  const dvec3& point() const noexcept { return mean_; }
  /// Returns true if every sample of the last touch with the verdict kTaken had six joint angles.
  bool has_joints() const noexcept { return has_joints_; }
  const std::array<double, 6>& joints() const noexcept { return joints_; }  // returns the mean joint angles, rad
  double moved() const noexcept { return moved_; }  // returns the largest distance (m) of a sample from point()

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
  std::vector<Sample> samples_;  // ring buffer of the samples
  std::size_t next_ = 0, count_ = 0;
  bool pedal_down_ = true;
  dvec3 mean_{0};
  bool has_joints_ = false;
  std::array<double, 6> joints_{};
  double moved_ = 0;
};

}  // namespace typodont::calibration
