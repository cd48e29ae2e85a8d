// The demonstration's hand: explores the lesion with the drill off in two directions, removes it with the expert's
// strokes, withdraws.
#pragma once

#include <memory>

#include "engine/app/hands/expert_hand.h"
#include "engine/app/scene.h"
#include "haptics/scripted_hand.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class Student {
 public:
  enum class Phase { kExplore, kDrill, kAway };

  /// `tissue`: at the start. Throws Error without caries or ideal result.
  Student(const Scene& scene, const haptics::TissueVolume& tissue, double rate);
  /// `now`: the present tissue. False at the end.
  bool read(haptics::HandSample& sample, const haptics::TissueVolume& now);
  /// The tick of the last sample.
  void see(const ServoTick& tick) noexcept;

  Phase phase() const { return phase_; }
  double done() const { return hand_->done(); }  // of the drilling, 0..1
  const haptics::HapticDevice& device() const { return *scripted_; }

 private:
  bool next(haptics::HandSample& sample, const haptics::TissueVolume& now);

  double rate_;  // Hz, rate of the servo
  std::uint64_t ticks_ = 0;
  Phase phase_ = Phase::kExplore;
  dvec3 above_{0};  // m, point above the lesion
  Pose last_;
  Expert expert_;
  std::unique_ptr<ExpertHand> hand_;
  std::unique_ptr<haptics::HapticDevice> scripted_;  // before and after the drilling
};

}  // namespace typodont
