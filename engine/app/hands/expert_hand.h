// "--hand expert:" of `typodont servo`: follows Expert's strokes in a closed loop. Each tick it reads the tool's pose
// and pulls the tool along; it presses until the tissue in the way is gone. Trainees can compare their session with it.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "engine/app/hands/expert.h"
#include "haptics/carver.h"
#include "haptics/haptic_device.h"

namespace typodont {

class ExpertHand final : public haptics::HapticDevice {
 public:
  ExpertHand(std::vector<ExpertLeg> legs, double rate, const ExpertGrip& grip = {});
  /// The orientation does not yield to a torque, as with a scripted hand.
  static haptics::DeviceInfo info_for(double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// The next position follows from this tick's pose.
  void see(const ServoTick& tick) noexcept override { seen_ = tick; }
  /// After read() has ended a plan. `legs` then holds the finished one, so that the servo thread frees no memory. Servo
  /// thread only.
  void go_on(std::vector<ExpertLeg>& legs) noexcept;
  double done() const { return static_cast<double>(leg_) / static_cast<double>(legs_.size()); }
  /// Pose at the start of the current step.
  const Pose& from() const { return from_; }

 private:
  void next_leg() noexcept;
  /// Next step of the run, reversal, or next run.
  void end_scraping() noexcept;
  /// Abandons a stroke: out along the shank, then to the next step, clear of tissue that should stay.
  void leave() noexcept;

  haptics::DeviceInfo info_;
  ExpertGrip grip_;
  std::vector<ExpertLeg> legs_;
  double dt_;
  ServoTick seen_;
  std::size_t leg_ = 0;
  std::array<ExpertLeg, 2> exit_legs_;  // withdrawal from an abandoned stroke
  /// step of exit_legs_; 2: follows the plan
  std::size_t way_ = 2;
  std::uint64_t ticks_ = 0;
  Pose from_;
  Pose free_;          // end of the last step through air
  double along_ = 0;   // m, from the step's start to the target point
  double filled_ = 0;  // m³, before the present step
  double waited_ = 0;  // s, since the tool last came nearer to the target
  // m, to the target since it last moved
  double nearest_ = std::numeric_limits<double>::infinity();
  // A run: strokes without a stop, scraped to and fro until the tool reaches the line.
  std::size_t run_ = 0;  // its first step
  Pose run_from_;        // pose at its start
  double worst_ = 0;     // m from the line, in the present pass
  int times_ = 0;        // returns to its start
  bool back_ = false;    // on the way back
  dvec3 lead_{0};        // m, target point to hand
  /// m, limit of a cut's lead, adjusted to the planned force
  double most_lead_;
};

/// The expert of a session on one thread. After each plan the next one, from the current tissue, until one is empty.
class PlanningExpert final : public haptics::HapticDevice {
 public:
  /// The carver must outlive this object. Throws Error without an ideal result or a tool that can begin.
  PlanningExpert(const Scene& scene, haptics::Carver& carver, double rate);
  const haptics::DeviceInfo& info() const noexcept override { return hand_.info(); }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  void see(const ServoTick& tick) noexcept override { hand_.see(tick); }
  double done() const { return hand_.done(); }  // of the current plan, 0..1
  const Pose& from() const { return hand_.from(); }

 private:
  haptics::Carver& carver_;
  Expert expert_;
  ExpertHand hand_;
};

}  // namespace typodont
