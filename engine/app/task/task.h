// Builds a task's ideal tissue, and compares results with it.
#pragma once

#include <atomic>
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

/// The target shape of the task; empty if the task has none. `start`: result of load_untouched(scene). Throws Error.
std::optional<haptics::TissueVolume> ideal_tissue(const Scene& scene, const haptics::TissueVolume& start);
/// The ideal shape; if there is none, the tissue with the planned implant's hole; without a plan, `start`.
haptics::TissueVolume finished_tissue(const Scene& scene, const haptics::TissueVolume& start);

/// Compares results with the ideal shape. Copies its arguments. Any number of threads.
class TaskEvaluator {
 public:
  /// Throws Error if the ideal shape is not valid.
  TaskEvaluator(const Scene& scene, const haptics::TissueVolume& start);

  bool has_ideal() const { return ideal_.has_value(); }
  const haptics::TissueVolume* ideal() const { return ideal_ ? &*ideal_ : nullptr; }

  /// Measures the tissue and stores the measures in `input`. Returns the compared tissues; empty for an exploration
  /// task. Takes about a second for a tooth, less if the region has not changed.
  std::optional<session::Preparation> judge(const haptics::TissueVolume& after, session::ScoreInput& input) const;
  /// Initial, final and ideal tissue on a common grid, around everything that changed or should have changed.
  session::Preparation preparation(const haptics::TissueVolume& after) const;
  /// The meter of an exploration task, which needs all ticks; its result is a part of the score's input.
  std::optional<session::ExploreMeter> explore_meter() const;

 private:
  haptics::TissueVolume start_;
  std::optional<haptics::TissueVolume> ideal_;
  std::optional<session::Task> task_;
  std::vector<std::unique_ptr<haptics::Solid>> protect_, region_;
  double tip_ = 0;  // m, radius of the first tool
  /// Data of the box in which tissues are compared; used again as long as the box does not change.
  struct Reference {
    dvec3 origin;  // m, frame W, origin of the box
    glm::ivec3 size;
    session::CavityReference cavity;
  };
  mutable std::atomic<std::shared_ptr<const Reference>> reference_;  // of the last judgement
};

/// What the score of a session without a recording needs in addition to the tissue.
struct FinishedHand {
  session::ScoreInput input;  // measured values of the hand, and the damage
  std::optional<session::ExploreMeter> explore;
  std::vector<ServoTick> unexplored;  // ticks of an exploration that are not yet evaluated
};
/// Computes the score that evaluate_session() would give for a recording. Takes a second or more. Throws Error if the
/// tissue or its ideal shape cannot be built.
session::Score final_score(const Scene& scene, const haptics::TissueVolume& after, FinishedHand hand);

/// A recorded session with its score, and with the tissue computed again from the cuts.
struct EvaluatedSession {
  Scene scene;
  haptics::TissueVolume start, after;
  std::optional<haptics::TissueVolume> ideal;
  std::optional<session::Preparation> preparation;  // tissue before and after, ideal shape; empty for an exploration
  session::ScoreInput input;
  session::Score score;
  // The session's cuts in order, without undone strokes. Valid while the session's reader exists.
  std::vector<const Cut*> cuts;
};
/// Evaluates a recorded session. Throws Error if its tissue is missing or has changed.
EvaluatedSession evaluate_session(const session::SessionReader& session);
/// Evaluates a session by the rules of `scene`, which otherwise equals the session's scene (scene_with).
EvaluatedSession evaluate_session(const session::SessionReader& session, Scene scene);

}  // namespace typodont
