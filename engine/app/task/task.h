// A scene's task and its tissue: the initial and the ideal volume, and the evaluation of a result against the ideal.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/cavity.h"
#include "engine/session/explore.h"
#include "engine/session/score.h"
#include "engine/session/session_file.h"
#include "haptics/solid.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// The ideal tissue; empty if the task has no ideal. `start`: load_tissue(scene). Throws Error.
std::optional<haptics::TissueVolume> ideal_tissue(const Scene& scene, const haptics::TissueVolume& start);

/// Evaluates results for one scene. The object copies its arguments, so they may change afterwards. One thread at a
/// time.
class TaskEvaluator {
 public:
  /// Builds the ideal. Throws Error if it cannot be built.
  TaskEvaluator(const Scene& scene, const haptics::TissueVolume& start);

  bool has_ideal() const { return ideal_.has_value(); }
  const haptics::TissueVolume* ideal() const { return ideal_ ? &*ideal_ : nullptr; }

  /// Adds the measures of the geometry of `after` to `input`, and returns the geometry (empty for an exploration task).
  /// Takes about a second for a tooth.
  std::optional<session::Preparation> judge(const haptics::TissueVolume& after, session::ScoreInput& input) const;
  /// Initial, final and ideal tissue on a common voxel grid, in the region that was changed or should have been
  /// changed.
  session::Preparation preparation(const haptics::TissueVolume& after) const;
  /// The meter of an exploration task. It must get the ticks, because its result is part of the score's input.
  std::optional<session::ExploreMeter> explore_meter() const;

 private:
  haptics::TissueVolume start_;
  std::optional<haptics::TissueVolume> ideal_;
  std::optional<session::Task> task_;
  std::vector<std::unique_ptr<haptics::Solid>> protect_, region_;
};

/// Data about the hand after a session, recorded or not. Together with the tissue, it determines the score.
struct FinishedHand {
  session::ScoreInput input;  // measures of the hand and damage
  std::optional<session::ExploreMeter> explore;
  std::vector<ServoTick> unexplored;  // ticks that no meter has processed
};
/// Score of a finished session, without the other data of the report. The score equals that of evaluate_session() for
/// the session's recording. Takes a second or more. Throws Error if the scene's tissue or its ideal cannot be built.
session::Score final_score(const Scene& scene, const haptics::TissueVolume& after, FinishedHand hand);

/// A recorded session with its tissue, rebuilt from the cuts, and its score.
struct EvaluatedSession {
  Scene scene;
  haptics::TissueVolume start, after;
  std::optional<haptics::TissueVolume> ideal;
  std::optional<session::Preparation> preparation;  // geometry of the result; empty for an exploration task
  session::ScoreInput input;
  session::Score score;
};
/// Rebuilds the tissue of the session and computes its score. Throws Error if the tissue is missing or has changed.
EvaluatedSession evaluate_session(const session::SessionReader& session);
/// Same as evaluate_session(), by the rules of `scene`. `scene` must equal the session's scene except for the rules
/// (scene_with).
EvaluatedSession evaluate_session(const session::SessionReader& session, Scene scene);

}  // namespace typodont
