// Plans steps that change the tissue to the task's ideal. ExpertHand (expert_hand.h) follows them.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"

namespace typodont {

/// m/s, of the target point along a cut
inline constexpr double kExpertCutPace = 40e-3;

/// A motion, a pause, or a change of tool.
struct ExpertLeg {
  enum class Kind {
    kMove,    // moves the tool through the air
    kCut,     // along a line, as fast as tissue goes
    kScrape,  // to and fro with a hand instrument until it reaches the line
    kWait,    // for a time, or until a volume is filled
    kTake,    // the servo changes the tool when the drill stands still
  } kind = Kind::kMove;
  Pose to;
  double pedal = 0;
  std::uint32_t tool = 0;
  double seconds = 0;
  double volume = 0;  // m³, at which kWait ends
  /// m/s, at this stroke's end and the next one's start; 0: stop
  double end_pace = 0;
  double force = 0;     // N, of the hand during a cut
  bool coarse = false;  // need not meet corners exactly
  bool rough = false;   // bulk with a coarse tool: wider tolerance
};

/// Body size and forces that scale the motion.
struct ExpertGrip {
  // factor on lengths of the motion; 1 for a tooth
  double size = 1;
  double force = 1;                                             // N, mean force that the task asks for
  double lead = 1e-3;                                           // m ahead of the tool, at the mean force
  double most_force = std::numeric_limits<double>::infinity();  // N, largest force of a cut
};

/// m, perpendicular to the axis, where a portion was added. Its hole can be entered again only exactly there.
struct FilledSpot {
  std::uint32_t tool = 0;
  double a = 0, b = 0;
};

/// Strokes to the ideal result with the scene's best tools: cavities, crowns and caries are cut, fillings built in
/// layers and carved.
class Expert {
 public:
  /// `start`: the tissue at the session's start. Throws Error without an ideal result.
  Expert(const Scene& scene, const haptics::TissueVolume& start);
  /// One layer of filling, or all cutting and carving. Empty if nothing improves the result. Throws Error if no tool
  /// can begin.
  std::vector<ExpertLeg> plan(const haptics::TissueVolume& now);
  const ExpertGrip& grip() const { return grip_; }
  /// What the last plan leaves if followed exactly.
  const haptics::TissueVolume& planned() const { return *planned_; }

 private:
  const Scene& scene_;
  const ExpertGrip grip_;
  TaskEvaluator judge_;
  std::optional<SurroundingsShape> around_;
  double whole_;  // m³ off the ideal at the start
  std::optional<haptics::TissueVolume> planned_;
  std::vector<FilledSpot> filled_;
  int layers_ = 0, cuts_ = 0;  // plans so far
  /// layers at the last carving; 0 after the first carving until filling continues
  int layers_cut_ = 0;
  double missing_ = 1e9;    // m³, smallest volume of missing filling so far
  double off_ = 0;          // m³ off the ideal before the last round of cutting
  int useless_layers_ = 0;  // in a row
  // of the filling instrument, 0 the finest; in the second pass plus their number
  std::size_t instrument_ = 0;
};

}  // namespace typodont
