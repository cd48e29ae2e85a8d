// The task of a scene: builds the initial and the ideal tissue, and evaluates a result by comparison with the ideal.
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

/// Builds the ideal tissue; empty if the task has no ideal. `start`: result of load_untouched(scene). Throws Error.
std::optional<haptics::TissueVolume> ideal_tissue(const Scene& scene, const haptics::TissueVolume& start);

/// Evaluates results for one scene. The object copies its arguments. Only one thread at a time may use it.
class TaskEvaluator {
 public:
  /// Builds the ideal result. Throws Error if it cannot be built.
  TaskEvaluator(const Scene& scene, const haptics::TissueVolume& start);

  bool has_ideal() const { return ideal_.has_value(); }
  const haptics::TissueVolume* ideal() const { return ideal_ ? &*ideal_ : nullptr; }

  /// Compares `after` with the ideal result. Adds the measured values to `input`, and returns the compared tissues
  /// (empty for an exploration task). Takes about a second for a tooth, and less if the last result changed the same
  /// region.
  std::optional<session::Preparation> judge(const haptics::TissueVolume& after, session::ScoreInput& input) const;
  /// Copies initial, final and ideal tissue to a common voxel grid. The grid covers the region that was changed or
  /// should have been changed.
  session::Preparation preparation(const haptics::TissueVolume& after) const;
  /// Makes the meter of an exploration task. Pass all ticks to it, because its result is part of the score's input.
  std::optional<session::ExploreMeter> explore_meter() const;

 private:
  haptics::TissueVolume start_;
  std::optional<haptics::TissueVolume> ideal_;
  std::optional<session::Task> task_;
  std::vector<std::unique_ptr<haptics::Solid>> protect_, region_;
  /// What the measures of the last result share with a result in the same box of voxels.
  struct Reference {
    dvec3 origin;  // frame W, m, of the box
    glm::ivec3 size;
    session::CavityReference cavity;
  };
  mutable std::optional<Reference> reference_;
};

/// Data about the hand after a session. The score is computed from these data and the tissue. A recording is not
/// needed.
struct FinishedHand {
  session::ScoreInput input;  // measured values of the hand, and the damage
  std::optional<session::ExploreMeter> explore;
  std::vector<ServoTick> unexplored;  // ticks of an exploration task that are not yet evaluated
};
/// Computes only the score of a finished session, not the other data of a report. The result equals that of
/// evaluate_session() for the session's recording. Takes a second or more. Throws Error if the scene's tissue or its
/// ideal result cannot be built.
session::Score final_score(const Scene& scene, const haptics::TissueVolume& after, FinishedHand hand);

/// A recorded session with its score, and with its tissue, which is rebuilt from the recorded cuts.
struct EvaluatedSession {
  Scene scene;
  haptics::TissueVolume start, after;
  std::optional<haptics::TissueVolume> ideal;
  std::optional<session::Preparation> preparation;  // the compared tissues; empty for an exploration task
  session::ScoreInput input;
  session::Score score;
};
/// Rebuilds the tissue of the session and computes its score. Throws Error if the tissue is missing or has changed.
EvaluatedSession evaluate_session(const session::SessionReader& session);
/// Does the same as evaluate_session() above, but with the score rules of `scene`. Except for the rules, `scene` must
/// equal the session's scene (see scene_with).
EvaluatedSession evaluate_session(const session::SessionReader& session, Scene scene);

}  // namespace typodont
