// The hand of the demonstration: explores the lesion in two directions with the drill off, removes it with the expert's
// strokes, and withdraws.
#pragma once

#include <memory>

#include "engine/app/hands/expert_hand.h"
#include "engine/app/scene.h"
#include "haptics/scripted_hand.h"

namespace typodont {

class DemoHand final : public haptics::HapticDevice {
 public:
  enum class Phase { kExplore, kDrill, kAway };

  /// The carver must outlive this object. Throws Error if there is no caries, or if the task has no ideal shape.
  DemoHand(const Scene& scene, haptics::Carver& carver, double rate);
  const haptics::DeviceInfo& info() const noexcept override { return scripted_->info(); }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  void see(const ServoTick& tick) noexcept override { expert_.see(tick); }

  Phase phase() const { return phase_; }

 private:
  bool next(haptics::HandSample& sample);

  double rate_;  // Hz, rate of the servo
  std::uint64_t ticks_ = 0;
  Phase phase_ = Phase::kExplore;
  dvec3 above_{0};  // m, point above the lesion
  Pose last_;
  PlanningExpert expert_;
  std::unique_ptr<haptics::HapticDevice> scripted_;  // the scripted hand before and after the drilling
};

}  // namespace typodont
