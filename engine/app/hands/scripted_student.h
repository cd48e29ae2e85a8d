// The hand of the demonstration: a simulated student. First, the student explores the lesion: the tool, with the drill
// off, moves over the surface in two directions. Then the student removes the caries with the strokes of the expert. At
// the end, the student withdraws the tool.
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

  /// `tissue`: the scene's initial tissue. Throws Error if the tissue contains no caries, or if the scene's task has no
  /// ideal result.
  Student(const Scene& scene, const haptics::TissueVolume& tissue, double rate);
  /// Computes the next sample. `now`: the present tissue. Returns false at the end.
  bool read(haptics::HandSample& sample, const haptics::TissueVolume& now);
  /// Receives the tick that resulted from the last sample.
  void see(const ServoTick& tick) noexcept;

  Phase phase() const { return phase_; }
  double done() const { return hand_->done(); }  // returns the fraction of the drilling that is complete, 0..1
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
  std::unique_ptr<haptics::HapticDevice> scripted_;  // hand that moves on a fixed path before and after the drilling
};

}  // namespace typodont
