// A hand that does all phases of an implant procedure: "--hand expert:" in scenes with an "implant" block.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/implant.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// It sees where its tool is and what it feels, presses with the force that a phase asks for, and goes on when the
/// exercise says that the phase is done. Same scene, same rate: the same hand.
class ImplantExpert final : public haptics::HapticDevice {
 public:
  /// The scene has an implant task.
  ImplantExpert(const Scene& scene, double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// What came of the last sample: the eyes of this hand.
  void see(const ServoTick& tick) noexcept override;
  double done() const;
  /// The phase that it gave up in, after too long without getting on; empty: none.
  std::string gave_up() const;

 private:
  enum class Stage { kTake, kApproach, kWork, kBack, kOver };
  const session::ImplantPhase& phase() const { return task_.phases[phase_]; }
  const haptics::Tool& tool() const { return tools_[phase().tool]; }
  /// m of the tip below the plan's entry, along its axis.
  double tip_depth() const;
  Pose at(double depth, const dvec3& aside = dvec3(0)) const;
  void work(haptics::HandSample& sample);
  void press(haptics::HandSample& sample, double newton, double depth);
  bool worked() const;
  bool must_cool();

  haptics::DeviceInfo info_;
  session::ImplantTask task_;
  std::vector<haptics::Tool> tools_;
  std::vector<dvec3> sweep_;  // m across the axis, of the smoothing bur
  session::ImplantMeter meter_;
  double dt_, stiffness_, motor_;
  ServoTick seen_;
  std::size_t phase_ = 0;
  Stage stage_ = Stage::kTake;
  std::uint64_t ticks_ = 0;
  double depth_ = 0;      // m, where the hand is
  double lead_ = 0;       // m that the hand is ahead of the tool
  double waited_ = 0;     // s in this stage
  double along_ = 0;      // m of the sweep that are done
  double pecked_ = 0;     // m, the depth at which the drill was last pulled back
  bool pulling_ = false;  // back, to let the bone cool
  bool cooling_ = false;  // the bone was too hot, and is not yet cool again
  bool gave_up_ = false;
};

/// The same in a live session: it keeps to the clock, and stands still while the session is held.
std::unique_ptr<haptics::HapticDevice> make_live_implant_expert(const Scene& scene, double rate);

}  // namespace typodont
