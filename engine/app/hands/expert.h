// Plans the steps that change the tissue to the task's target shape (ideal). ExpertHand (expert_hand.h) follows them.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"

namespace typodont {

/// Speed of the target point along a cut, m/s.
inline constexpr double kExpertCutPace = 40e-3;

/// One step of a plan: a motion, a pause, or a change of tool.
struct ExpertLeg {
  enum class Kind {
    kMove,    // moves the tool through the air
    kCut,     // moves along a line at the speed of the cut
    kScrape,  // moves a hand instrument to and fro towards the line
    kWait,    // waits for a time, or until a volume is filled
    kTake,    // the servo changes the tool when the drill stands still
  } kind = Kind::kMove;
  Pose to;
  double pedal = 0;
  std::uint32_t tool = 0;
  double seconds = 0;
  double volume = 0;  // m³; kWait ends when this volume is filled
  /// Speed at the end of this stroke and the start of the next one, m/s; 0: stop.
  double end_pace = 0;
  double force = 0;     // N, force of the hand during a cut
  bool drills = false;  // true: with a bur; false: with a hand instrument
  bool coarse = false;  // true: the tool need not reach corners exactly
  bool rough = false;   // true: bulk removal with a coarse tool and wide tolerance
};

/// Margins of planned cuts, m.
struct PlanMargins {
  double clearance = 0;  // smallest distance of the head from neighbouring teeth and gum
  /// Additional depth of a hand instrument that scrapes a deposit, such as calculus, off the tooth. The tooth is harder
  /// and stops the instrument, so the hand presses on the last film of the deposit.
  double into_tooth = 0;
};
/// Margins of a plan that is followed exactly, and of one that a trembling hand follows through the servo.
inline constexpr PlanMargins kExactMargins{.clearance = 0.03e-3},
    kHandMargins{.clearance = 0.08e-3, .into_tooth = 0.05e-3};

/// Size of the treated object, distances and forces, which scale the motion.
struct ExpertGrip {
  // Factor on all lengths of the motion; 1 for a tooth.
  double size = 1;
  PlanMargins margins;
  double force = 1;    // N, mean force that the task requires
  double lead = 1e-3;  // m, distance of the hand ahead of the tool at the mean force
  double max_force = std::numeric_limits<double>::infinity();  // N, largest force of a cut
};

/// Position where a portion of filling was added, m, perpendicular to the axis. The hole
/// that the instrument left there can be entered again only at exactly this position.
struct FilledSpot {
  std::uint32_t tool = 0;
  double a = 0, b = 0;
};

/// Plans strokes to the task's target shape with the scene's best tools: cuts cavities, crowns and caries; builds up
/// fillings in layers and carves them.
class Expert {
 public:
  /// `start`: the tissue at the session's start. `margins`: kExactMargins or kHandMargins. Throws Error if the task
  /// has no target shape (ideal).
  Expert(const Scene& scene, const haptics::TissueVolume& start, const PlanMargins& margins);
  /// Plans one layer of filling, or all cutting and carving. If no tool improves the result, the first call throws
  /// Error, and later calls return an empty plan.
  std::vector<ExpertLeg> plan(const haptics::TissueVolume& now);
  const ExpertGrip& grip() const { return grip_; }
  const TaskEvaluator& judge() const { return judge_; }
  /// The tissue that results if the last plan is followed exactly.
  const haptics::TissueVolume& planned() const { return *planned_; }

 private:
  const Scene& scene_;
  const ExpertGrip grip_;
  TaskEvaluator judge_;
  std::optional<SurroundingsShape> around_;
  double whole_;  // m³, volume that differs from the ideal shape at the start
  std::optional<haptics::TissueVolume> planned_;
  std::vector<FilledSpot> filled_;
  int layers_ = 0, cuts_ = 0;  // number of plans so far that fill, and that cut
  /// 0 before the second pass of filling; then the number of layers at its beginning, or at the last carving after it.
  int layers_cut_ = 0;
  double missing_ = 1e9;    // m³, smallest volume of missing filling so far
  double off_ = 0;          // m³, difference from the ideal shape before the last round of cutting
  int useless_layers_ = 0;  // number of layers in a row that added hardly any missing filling
  // Index of the filling instrument, 0: the finest. In the second pass: this index + number of instruments.
  std::size_t instrument_ = 0;
};

}  // namespace typodont
