// A simulated hand that carries out a task: "--hand expert:" of `typodont servo`. Expert plans the strokes from the
// task's ideal. ExpertHand follows them in a closed loop: it reads the tool's pose, leads the tool along the stroke,
// presses while tissue blocks the tool, and continues when the tissue has been removed. Trainees can watch the
// recorded session, and compare their own with it.
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

/// One step of a plan.
struct ExpertLeg {
  enum class Kind {
    kMove,    // moves through the air
    kCut,     // cuts along a line, as fast as the tissue is removed
    kScrape,  // draws an edge to and fro along a line until the tool reaches the line
    kWait,    // waits for a time, or until a volume has been filled
    kTake,    // takes another tool, once the drill stands still
  } kind = Kind::kMove;
  Pose to;
  double pedal = 0;
  std::uint32_t tool = 0;
  double seconds = 0;
  double volume = 0;    // m³, for kWait: the step ends when this volume has been filled
  double end_pace = 0;  // m/s, pace at the end of a stroke that continues in the next step; 0: the stroke stops there
  double force = 0;     // N, push of a cut
};

/// Size and forces of a task.
struct ExpertGrip {
  double size = 1;     // factor on the lengths that are given for work on a tooth: distances, clearances, tolerances
  double force = 1;    // N, mean force that the task prescribes
  double lead = 1e-3;  // m, lead of the hand over its tool that gives the mean force
  double most_force = std::numeric_limits<double>::infinity();  // N, limit of the push of a cut
};

/// Position of a filled portion: m along the two axes perpendicular to the preparation's axis. The instrument leaves a
/// hole there, and fits into the hole only at this position.
struct FilledSpot {
  std::uint32_t tool = 0;
  double a = 0, b = 0;
};

/// Plans the strokes that bring the tissue to the ideal of the scene's task. Among the scene's tools, chooses those
/// with which the result comes closest to the ideal. Cavities, crowns and caries are cut; fillings are added in
/// layers and carved.
class Expert {
 public:
  /// `start`: the tissue at the session's start. Throws Error if the task has no ideal.
  Expert(const Scene& scene, const haptics::TissueVolume& start);
  /// Plans from the present tissue: one layer of filling, or all cutting and carving. Returns an empty plan if no
  /// further plan would improve the result. Throws Error if no tool of the scene can begin the task.
  std::vector<ExpertLeg> plan(const haptics::TissueVolume& now);
  const ExpertGrip& grip() const { return grip_; }
  /// The tissue that the last plan would leave if the tool followed it exactly.
  const haptics::TissueVolume& planned() const { return *planned_; }

 private:
  const Scene& scene_;
  const ExpertGrip grip_;
  TaskEvaluator judge_;
  std::optional<SurroundingsShape> around_;
  double whole_;  // m³, difference between the tissue and the ideal at the start
  std::optional<haptics::TissueVolume> planned_;
  std::vector<FilledSpot> filled_;
  int layers_ = 0, cuts_ = 0;  // numbers of plans up to now: for filling, for cutting
  int layers_cut_ = 0;      // number of layers before the last carving; 0 until filling resumes after the first carving
  double missing_ = 1e9;    // m³, smallest missing volume of filling up to now
  double off_ = 0;          // m³, difference between the tissue and the ideal before the last cutting
  int useless_layers_ = 0;  // consecutive layers that reduced the missing volume too little
  // index of the filling instrument, finest first; a second pass over all instruments, which overfills, continues the
  // numbering
  std::size_t instrument_ = 0;
};

class ExpertHand final : public haptics::HapticDevice {
 public:
  ExpertHand(std::vector<ExpertLeg> legs, double rate, const ExpertGrip& grip = {});
  /// Properties of an expert hand. Like a scripted hand, it keeps its orientation at any torque.
  static haptics::DeviceInfo info_for(double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// Stores the servo's last tick; the hand's lead is measured from the tool pose in this tick.
  void see(const ServoTick& tick) noexcept override { seen_ = tick; }
  /// Begins the next plan, after read() has ended the last one. Swaps the plans: afterwards `legs` contains the
  /// finished plan, so that the servo thread frees no memory. Servo thread.
  void go_on(std::vector<ExpertLeg>& legs) noexcept;
  double done() const { return static_cast<double>(leg_) / static_cast<double>(legs_.size()); }

 private:
  void next_leg() noexcept;
  /// Called at the end of an edge's leg. Continues along the run, reverses, or begins the next run.
  void end_scraping() noexcept;
  /// Leaves a stroke that the hand cannot finish: withdraws along the shank, then moves to the start of the next leg. A
  /// direct move could press into tissue that should stay.
  void leave() noexcept;

  haptics::DeviceInfo info_;
  ExpertGrip grip_;
  std::vector<ExpertLeg> legs_;
  double dt_;
  ServoTick seen_;
  std::size_t leg_ = 0;
  std::array<ExpertLeg, 2> exit_legs_;  // legs with which the hand leaves a stroke
  std::size_t way_ = 2;                 // index of the current leg in exit_legs_; 2: the hand follows its plan
  std::uint64_t ticks_ = 0;
  Pose from_;          // start of the present leg
  Pose free_;          // end of the last leg through the air
  double along_ = 0;   // m, distance from the leg's start to the wanted position
  double filled_ = 0;  // m³, volume filled from the session's start to the start of this leg
  double waited_ = 0;  // s without progress
  // m, smallest distance of the tool from the wanted position since this position last moved
  double nearest_ = std::numeric_limits<double>::infinity();
  // Consecutive strokes of an edge without a stop form a run. The hand draws the edge to and fro along the run until
  // the tool reaches the wanted line.
  std::size_t run_ = 0;  // index of the first leg of the run
  Pose run_from_;        // start of the run's first leg
  double worst_ = 0;     // m, largest distance of the tool from the line in this pass
  int times_ = 0;        // number of completed passes back along the run
  bool back_ = false;    // the present pass goes back
  dvec3 lead_{0};        // m, vector from the wanted position to the hand
  double most_lead_;     // m, limit of a cut's lead; it is adjusted until the push equals the leg's force
};

/// Runs the hand in simulated time. After each finished plan, the expert makes the next plan from the present tissue,
/// until a plan is empty. `each` is called after every tick.
void run_expert(HapticLoop& loop, ExpertHand& hand, Expert& expert,
                const std::function<void(const ServoTick&, const Cut*)>& each);

}  // namespace typodont
