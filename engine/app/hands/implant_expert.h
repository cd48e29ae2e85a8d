// "--hand expert:" in scenes with an "implant" block: performs all phases of the procedure.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/implant.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Presses with the force of a phase until the exercise reports that this phase is done. Deterministic.
class ImplantExpert final : public haptics::HapticDevice {
 public:
  /// `rate`: rate of the servo, Hz.
  ImplantExpert(const Scene& scene, double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// Stores the tick that the servo computed from the last sample.
  void see(const ServoTick& tick) noexcept override;
  double done() const;
  /// Name of the phase that took too long; empty: none.
  std::string gave_up() const;

 private:
  enum class Stage { kTake, kApproach, kWork, kBack, kOver };
  const session::ImplantPhase& phase() const { return task_.phases[phase_]; }
  const haptics::Tool& tool() const { return tools_[phase().tool]; }
  /// Displacement from the entry point to the tool's tip, m, frame W.
  dvec3 tip_from_entry() const;
  /// The tip's depth below the entry, along the axis, m.
  double tip_depth() const;
  /// The tip's displacement from the axis, m, in the same axes as the argument `aside` of at().
  dvec3 tip_aside() const;
  Pose at(double depth, const dvec3& aside = dvec3(0)) const;
  void work(haptics::HandSample& sample);
  void press(haptics::HandSample& sample, double newton, double depth);
  bool worked() const;
  bool must_cool();

  haptics::DeviceInfo info_;
  session::ImplantTask task_;
  std::vector<haptics::Tool> tools_;
  std::vector<dvec3> sweep_;  // m, path of the smoothing bur across the axis
  session::ImplantMeter meter_;
  double dt_, stiffness_, motor_;
  ServoTick seen_;
  std::size_t phase_ = 0;
  Stage stage_ = Stage::kTake;
  std::uint64_t ticks_ = 0;
  // Depth that the tip would have if the tool followed the hand exactly, m below the entry point.
  double depth_ = 0;
  double lead_ = 0;       // m, distance of the hand ahead of the tool
  dvec3 aside_{0};        // m, offset of the hand that keeps the tip on the axis
  double waited_ = 0;     // s, time since the phase's current stage began
  double along_ = 0;      // m, part of the smoothing path that the bur has completed
  double pecked_ = 0;     // m, depth of the drill at its last withdrawal
  bool pulling_ = false;  // true: the drill is withdrawn, so that the bone cools
  bool cooling_ = false;  // true: waits until the bone has cooled
  bool gave_up_ = false;
};

}  // namespace typodont
