// "--hand expert:" in scenes with an "implant" block: all phases of the procedure.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/implant.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Presses with the phase's force, and goes on when the exercise reports it done. Deterministic.
class ImplantExpert final : public haptics::HapticDevice {
 public:
  /// `rate`: of the servo, Hz.
  ImplantExpert(const Scene& scene, double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// The tick of the last sample.
  void see(const ServoTick& tick) noexcept override;
  double done() const;
  /// Name of a phase that took too long; empty: none.
  std::string gave_up() const;

 private:
  enum class Stage { kTake, kApproach, kWork, kBack, kOver };
  const session::ImplantPhase& phase() const { return task_.phases[phase_]; }
  const haptics::Tool& tool() const { return tools_[phase().tool]; }
  /// m below the entry point, along the axis.
  double tip_depth() const;
  Pose at(double depth, const dvec3& aside = dvec3(0)) const;
  void work(haptics::HandSample& sample);
  void press(haptics::HandSample& sample, double newton, double depth);
  bool worked() const;
  bool must_cool();

  haptics::DeviceInfo info_;
  session::ImplantTask task_;
  std::vector<haptics::Tool> tools_;
  std::vector<dvec3> sweep_;  // m, path across the axis
  session::ImplantMeter meter_;
  double dt_, stiffness_, motor_;
  ServoTick seen_;
  std::size_t phase_ = 0;
  Stage stage_ = Stage::kTake;
  std::uint64_t ticks_ = 0;
  // m below the entry point, of the tip if the tool followed exactly
  double depth_ = 0;
  double lead_ = 0;       // m ahead of the tool
  double waited_ = 0;     // s, since the stage began
  double along_ = 0;      // m, completed length of the smoothing path
  double pecked_ = 0;     // m, at the last pull
  bool pulling_ = false;  // pulled back to cool
  bool cooling_ = false;  // waits until cooled
  bool gave_up_ = false;
};

/// For live sessions: real clock, and still during an emergency stop.
std::unique_ptr<haptics::HapticDevice> make_live_implant_expert(const Scene& scene, double rate);

}  // namespace typodont
