// "--hand expert:" in a task that measures pockets: probes site after site.
#pragma once

#include <vector>

#include "engine/app/scene.h"
#include "engine/base/ticker.h"
#include "haptics/haptic_device.h"

namespace typodont {

struct ProbingHabit {
  dvec3 slip{0};         // m, displacement of the place where the probe enters
  double force = 0.2;    // N, at which the hand takes a reading
  double lean = 0.1e-3;  // m, hand ahead of the tool towards the tooth; this presses the ball on the root
};

/// Lowers the probe into each pocket, yields to its walls, and takes a reading where the floor resists. It knows where
/// the sites are, but not their depth. Equal ticks give equal samples.
class ProbingHand final : public haptics::HapticDevice {
 public:
  /// `rate`: rate of the servo, Hz.
  ProbingHand(const Scene& scene, double rate, const ProbingHabit& habit = {});
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  void see(const ServoTick& tick) noexcept override { seen_ = tick; }

 private:
  enum class Stage { kTravel, kLower, kHold, kMark, kRaise };
  void go(const Pose& to) noexcept;

  haptics::DeviceInfo info_;
  ProbingHabit habit_;
  std::vector<std::vector<Pose>> entries_;  // poses on the way to each site; the last is above the pocket
  std::vector<dvec3> out_;                  // for each site: horizontal unit vector away from the tooth
  std::vector<Pose> way_;
  double dt_;  // s
  Ticker ticker_;
  ServoTick seen_;
  Pose at_;
  std::size_t site_ = 0, leg_ = 0;
  Stage stage_ = Stage::kTravel;
  double waited_ = 0;  // s, since the stage began
  double depth_ = 0;   // m, lowered since the entry
};

}  // namespace typodont
