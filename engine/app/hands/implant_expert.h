// A simulated hand that performs all phases of an implant procedure: "--hand expert:" in scenes with an "implant"
// block.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/implant.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// A simulated hand for implant surgery. It reads the tool's pose and force, presses with the force of the present
/// phase, and begins the next phase when the exercise reports that the phase is done. The same scene and rate give the
/// same motion.
class ImplantExpert final : public haptics::HapticDevice {
 public:
  /// `scene`: must contain an implant exercise. `rate`: rate of the servo, Hz.
  ImplantExpert(const Scene& scene, double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// Receives the servo's tick that resulted from the last sample.
  void see(const ServoTick& tick) noexcept override;
  double done() const;
  /// Returns the name of the phase that took too long and was abandoned; empty if there is none.
  std::string gave_up() const;

 private:
  enum class Stage { kTake, kApproach, kWork, kBack, kOver };
  const session::ImplantPhase& phase() const { return task_.phases[phase_]; }
  const haptics::Tool& tool() const { return tools_[phase().tool]; }
  /// Returns the depth (m) of the tool's tip below the planned entry point, along the planned axis.
  double tip_depth() const;
  Pose at(double depth, const dvec3& aside = dvec3(0)) const;
  void work(haptics::HandSample& sample);
  void press(haptics::HandSample& sample, double newton, double depth);
  bool worked() const;
  bool must_cool();

  haptics::DeviceInfo info_;
  session::ImplantTask task_;
  std::vector<haptics::Tool> tools_;
  std::vector<dvec3> sweep_;  // m, path of the smoothing bur across the implant's axis
  session::ImplantMeter meter_;
  double dt_, stiffness_, motor_;
  ServoTick seen_;
  std::size_t phase_ = 0;
  Stage stage_ = Stage::kTake;
  std::uint64_t ticks_ = 0;
  // m, depth below the planned entry point at which the tool's tip would be if the tool followed the hand exactly
  double depth_ = 0;
  double lead_ = 0;       // m, lead: distance of the hand ahead of its tool
  double waited_ = 0;     // s, time since the present stage (Stage) of the phase began
  double along_ = 0;      // m, completed length of the smoothing path
  double pecked_ = 0;     // m, depth at which the drill was last pulled back
  bool pulling_ = false;  // true while the drill is pulled back to let the bone cool
  bool cooling_ = false;  // true while the hand waits for the bone to cool, after it became too hot
  bool gave_up_ = false;
};

/// Makes an ImplantExpert for a live session. Its motion follows the real clock, and stops during an emergency stop.
std::unique_ptr<haptics::HapticDevice> make_live_implant_expert(const Scene& scene, double rate);

}  // namespace typodont
