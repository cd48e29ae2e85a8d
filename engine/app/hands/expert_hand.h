// A simulated hand that carries out a task: "--hand expert:" of `typodont servo`. Expert (expert.h) plans strokes that
// change the tissue to the task's ideal result. ExpertHand follows the strokes in a closed loop. In every tick, the
// hand reads the tool's pose and pulls the tool along the stroke. While tissue blocks the tool, the hand presses; when
// this tissue is removed, the hand goes on. Trainees can watch the recording of this hand's session and compare their
// own session with it.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <vector>

#include "engine/app/hands/expert.h"
#include "engine/app/haptic_loop.h"
#include "haptics/haptic_device.h"

namespace typodont {

class ExpertHand final : public haptics::HapticDevice {
 public:
  ExpertHand(std::vector<ExpertLeg> legs, double rate, const ExpertGrip& grip = {});
  /// Returns the properties of an expert hand as a device. The orientation of the hand does not change under a torque,
  /// as with a scripted hand.
  static haptics::DeviceInfo info_for(double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// Stores the servo's last tick. The hand computes its next position from the tool's pose in this tick.
  void see(const ServoTick& tick) noexcept override { seen_ = tick; }
  /// Begins the next plan, after read() has ended the last plan. The two plans are swapped: afterwards `legs` contains
  /// the finished plan, so that the servo thread frees no memory. Servo thread only.
  void go_on(std::vector<ExpertLeg>& legs) noexcept;
  double done() const { return static_cast<double>(leg_) / static_cast<double>(legs_.size()); }

 private:
  void next_leg() noexcept;
  /// Ends a scraping step: continues with the next step of the run (stroke sequence), reverses, or begins the next run.
  void end_scraping() noexcept;
  /// Abandons a stroke that the hand cannot finish. The tool withdraws along its shank, then moves to the start of the
  /// next step. A direct move could press the tool into tissue that should stay.
  void leave() noexcept;

  haptics::DeviceInfo info_;
  ExpertGrip grip_;
  std::vector<ExpertLeg> legs_;
  double dt_;
  ServoTick seen_;
  std::size_t leg_ = 0;
  std::array<ExpertLeg, 2> exit_legs_;  // steps in which the hand withdraws from an abandoned stroke
  /// index of the present withdrawal step in exit_legs_; 2: the hand follows its plan
  std::size_t way_ = 2;
  std::uint64_t ticks_ = 0;
  Pose from_;          // pose at the start of the present step
  Pose free_;          // pose at the end of the last step through the air
  double along_ = 0;   // m, distance from the start of the step to the target point
  double filled_ = 0;  // m³, volume that was filled before the present step
  double waited_ = 0;  // s, time since the tool last came nearer to the target point
  // m, smallest distance of the tool from the target point since this point last moved
  double nearest_ = std::numeric_limits<double>::infinity();
  // A run is a sequence of strokes of a hand instrument without a stop. The instrument scrapes to and fro along the run
  // until the tool reaches the planned line.
  std::size_t run_ = 0;  // index of the first step of the run (sequence of strokes)
  Pose run_from_;        // pose at the start of the run (sequence of strokes)
  double worst_ = 0;     // m, largest distance of the tool from the planned line in the present pass
  int times_ = 0;        // number of times that the hand has moved back to the start of the run
  bool back_ = false;    // true while the hand moves back along the run (sequence of strokes)
  dvec3 lead_{0};        // m, vector from the target point to the hand
  /// m, largest lead (distance ahead of the target point) of a cut, adjusted until the force equals the planned force
  double most_lead_;
};

/// Runs the hand in simulated time. After each finished plan, the expert makes the next plan from the present tissue.
/// The run ends when a plan is empty. `each` is called after every tick.
void run_expert(HapticLoop& loop, ExpertHand& hand, Expert& expert,
                const std::function<void(const ServoTick&, const Cut*)>& each);

}  // namespace typodont
