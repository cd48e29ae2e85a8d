// Plans the work of a simulated hand that carries out a task: a list of steps that change the tissue to the task's
// ideal result. ExpertHand (expert_hand.h) follows the steps.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"

namespace typodont {

/// m/s, largest speed of the target point along a cut
inline constexpr double kExpertCutPace = 40e-3;

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

}  // namespace typodont
