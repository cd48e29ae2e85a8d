// "--hand expert:" of `typodont servo`: follows the strokes of Expert. In each tick, it reads the tool's pose and pulls
// the tool along the stroke until the tissue in the way is removed. Trainees can compare their sessions with it.
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
  /// Like a scripted hand, this hand does not turn when a torque acts on it.
  static haptics::DeviceInfo info_for(double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// Stores the servo's tick. The next position of the hand depends on the tool's pose in this tick.
  void see(const ServoTick& tick) noexcept override { seen_ = tick; }
  /// Continues with a new plan after read() has finished one. Afterwards, `legs` contains the finished plan, so that
  /// the servo thread frees no memory. Servo thread only.
  void go_on(std::vector<ExpertLeg>& legs) noexcept;
  double done() const { return static_cast<double>(leg_) / static_cast<double>(legs_.size()); }
  /// Pose at the start of the current step.
  const Pose& from() const { return from_; }

 private:
  void next_leg() noexcept;
  bool on_tooth() const { return grip_.size == 1; }
  /// Begins and ends the pauses between contacts of a drill with a tooth.
  void keep_rhythm(const ExpertLeg& leg) noexcept;
  /// Ends a stroke of scraping: continues with the next step of the run, reverses, or begins the next run.
  void end_scraping() noexcept;
  /// Abandons a stroke: moves out along the shank, then to the next step, without touching tissue that must stay.
  void leave() noexcept;

  haptics::DeviceInfo info_;
  ExpertGrip grip_;
  std::vector<ExpertLeg> legs_;
  double dt_;
  ServoTick seen_;
  std::size_t leg_ = 0;
  std::array<ExpertLeg, 2> exit_legs_;  // withdrawal from an abandoned stroke
  /// Index of the current step in exit_legs_; 2 (past its end): no withdrawal, the hand follows the plan.
  std::size_t way_ = 2;
  std::uint64_t ticks_ = 0;
  Pose from_;
  Pose free_;          // target pose of the latest step through the air
  double along_ = 0;   // m, distance from the step's start to the target point
  double filled_ = 0;  // m³, filled volume before the current step
  double waited_ = 0;  // s, time since the tool last approached the target
  // Smallest distance from the tool to the target point since the target last moved, m.
  double nearest_ = std::numeric_limits<double>::infinity();
  // A run consists of strokes without a stop between them. A scraping tool repeats the run, to and fro, until it stays
  // near the planned line of the strokes.
  std::size_t run_ = 0;      // index of the run's first step
  Pose run_from_;            // pose at the start of the run
  double worst_ = 0;         // m, largest distance of the tool from the line in this pass
  double removed_ = 0;       // m³, volume that was removed before this pass
  double most_removed_ = 0;  // m³, largest volume that a pass of this run removed
  bool back_ = false;        // true: moves back along the current run of strokes
  dvec3 lead_{0};            // m, displacement from the target point to the hand
  double beat_ = 0;          // s, duration of the current contact, or of the pause after it
  bool pauses_ = false;      // true: between two contacts
  // position of the tool when the pause began, m, and direction in which it leaves the tissue
  dvec3 left_at_W_{0}, leaves_W_{0};
  /// m, upper limit of |lead_| (distance from target point to hand) in a cut, adjusted to reach the planned force.
  double max_lead_;
};

/// An expert that plans and moves on one thread. When a plan is finished,
/// it makes the next plan from the current tissue, until a plan is empty.
class PlanningExpert final : public haptics::HapticDevice {
 public:
  /// The carver must outlive this object. Throws Error if the task has no target shape (ideal), or if no tool brings
  /// the tissue nearer to it.
  PlanningExpert(const Scene& scene, haptics::Carver& carver, double rate);
  const haptics::DeviceInfo& info() const noexcept override { return hand_.info(); }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  void see(const ServoTick& tick) noexcept override { hand_.see(tick); }
  double done() const { return hand_.done(); }  // finished fraction of the current plan, 0 to 1
  const Pose& from() const { return hand_.from(); }

 private:
  haptics::Carver& carver_;
  Expert expert_;
  ExpertHand hand_;
};

}  // namespace typodont
