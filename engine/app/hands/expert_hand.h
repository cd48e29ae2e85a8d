// A simulated hand that carries out a task: "--hand expert:" of `typodont servo`. Expert plans strokes that change the
// tissue to the task's ideal result. ExpertHand follows the strokes in a closed loop. In every tick, the hand reads the
// tool's pose and pulls the tool along the stroke. While tissue blocks the tool, the hand presses; when this tissue is
// removed, the hand goes on. Trainees can watch the recording of this hand's session and compare their own session with
// it.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "engine/app/haptic_loop.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// One step of a plan: a motion, a pause, or a change of the tool.
struct ExpertLeg {
  enum class Kind {
    kMove,    // moves the tool through the air
    kCut,     // cuts along a line, as fast as tissue is removed
    kScrape,  // scrapes with a hand instrument to and fro along a line until the tool reaches the line
    kWait,    // waits for a time, or until a volume has been filled
    kTake,    // changes the tool; the servo does this when the drill stands still
  } kind = Kind::kMove;
  Pose to;
  double pedal = 0;
  std::uint32_t tool = 0;
  double seconds = 0;
  double volume = 0;  // m³; a step of the kind kWait ends when this volume has been filled
  /// m/s, speed at the end of this stroke; the next step starts with the same speed. 0: the hand stops
  double end_pace = 0;
  double force = 0;     // N, force with which the hand pushes during a cut
  bool coarse = false;  // true: a coarse tool cuts; the tool need not meet a corner between two strokes exactly
  bool rough = false;   // true: a coarse tool removes the bulk; its path may deviate more from the planned line
};

/// Size of the body that the task treats, and forces of the task. The hand's motion is scaled with these values.
struct ExpertGrip {
  // factor for the lengths of the hand's motion (distances, clearances, tolerances): 1 for a tooth, larger for a larger
  // body
  double size = 1;
  double force = 1;    // N, mean force that the task asks for
  double lead = 1e-3;  // m, distance of the hand ahead of its tool at which the force equals the mean force
  double most_force = std::numeric_limits<double>::infinity();  // N, largest force of a cut
};

/// Position at which a portion of filling was added, m along the two axes perpendicular to the preparation's axis. The
/// instrument leaves a hole in the filling there, and can enter this hole again only at exactly the same position.
struct FilledSpot {
  std::uint32_t tool = 0;
  double a = 0, b = 0;
};

/// Plans strokes that change the tissue to the ideal result of the scene's task. Chooses the tools of the scene that
/// come nearest to this result. Cavities, crowns and caries are cut. Fillings are added in layers and then carved.
class Expert {
 public:
  /// `start`: the tissue at the session's start. Throws Error if the task has no ideal result.
  Expert(const Scene& scene, const haptics::TissueVolume& start);
  /// Makes the next plan for the present tissue: one layer of filling, or all cutting and carving. Returns an empty
  /// plan if no plan would improve the result. Throws Error if no tool of the scene can begin the task.
  std::vector<ExpertLeg> plan(const haptics::TissueVolume& now);
  const ExpertGrip& grip() const { return grip_; }
  /// Returns the tissue that the last plan would leave if the tool followed it exactly.
  const haptics::TissueVolume& planned() const { return *planned_; }

 private:
  const Scene& scene_;
  const ExpertGrip grip_;
  TaskEvaluator judge_;
  std::optional<SurroundingsShape> around_;
  double whole_;  // m³, volume that differed from the ideal result at the start
  std::optional<haptics::TissueVolume> planned_;
  std::vector<FilledSpot> filled_;
  int layers_ = 0, cuts_ = 0;  // number of plans so far for filling, and for cutting
  /// Number of layers that had been filled when the last carving was planned. It stays 0 after the first carving until
  /// filling continues.
  int layers_cut_ = 0;
  double missing_ = 1e9;    // m³, smallest volume of missing filling so far
  double off_ = 0;          // m³, volume that differed from the ideal result before the last round of cutting
  int useless_layers_ = 0;  // number of consecutive layers that hardly reduced the missing volume
  // Index of the filling instrument; the finest has index 0. In the second pass, which overfills, the number of
  // instruments is added to the index.
  std::size_t instrument_ = 0;
};

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
