// The hand of the demo: a student who looks before drilling. It draws the tool over the lesion with the drill at rest,
// in both directions, removes the caries as the expert does, and draws the tool away.
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

  /// `tissue` as the scene begins. Throws Error when it holds no caries or the scene's task names no ideal.
  Student(const Scene& scene, const haptics::TissueVolume& tissue, double rate);
  /// The next sample, `now` being the tissue as it is; false at the end.
  bool read(haptics::HandSample& sample, const haptics::TissueVolume& now);
  /// What came of it.
  void see(const ServoTick& tick) noexcept;

  Phase phase() const { return phase_; }
  double done() const { return hand_->done(); }  // share of the drilling
  const haptics::HapticDevice& device() const { return *scripted_; }

 private:
  bool next(haptics::HandSample& sample, const haptics::TissueVolume& now);

  double rate_;  // Hz
  std::uint64_t ticks_ = 0;
  Phase phase_ = Phase::kExplore;
  dvec3 above_{0};  // m, over the lesion
  Pose last_;
  Expert expert_;
  std::unique_ptr<ExpertHand> hand_;
  std::unique_ptr<haptics::HapticDevice> scripted_;  // before and after that
};

}  // namespace typodont
