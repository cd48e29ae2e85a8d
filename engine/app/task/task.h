// Initial and ideal tissue of a scene's task, and the comparison of a result with them.
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

/// Empty without an ideal. `start`: of load_untouched(scene). Throws Error.
std::optional<haptics::TissueVolume> ideal_tissue(const Scene& scene, const haptics::TissueVolume& start);
/// The ideal; else the planned implant's bed; else `start`.
haptics::TissueVolume finished_tissue(const Scene& scene, const haptics::TissueVolume& start);

/// Copies its arguments. One thread at a time.
class TaskEvaluator {
 public:
  /// Throws Error without a valid ideal.
  TaskEvaluator(const Scene& scene, const haptics::TissueVolume& start);

  bool has_ideal() const { return ideal_.has_value(); }
  const haptics::TissueVolume* ideal() const { return ideal_ ? &*ideal_ : nullptr; }

  /// Measures go to `input`; returns the compared tissues, empty for an exploration. About a second for a tooth, less
  /// in the same region again.
  std::optional<session::Preparation> judge(const haptics::TissueVolume& after, session::ScoreInput& input) const;
  /// Initial, final and ideal tissue on a common grid around what changed or should have.
  session::Preparation preparation(const haptics::TissueVolume& after) const;
  /// Needs all ticks; it is part of the score's input.
  std::optional<session::ExploreMeter> explore_meter() const;

 private:
  haptics::TissueVolume start_;
  std::optional<haptics::TissueVolume> ideal_;
  std::optional<session::Task> task_;
  std::vector<std::unique_ptr<haptics::Solid>> protect_, region_;
  /// Shared with a result in the same box.
  struct Reference {
    dvec3 origin;  // frame W, m, of the box
    glm::ivec3 size;
    session::CavityReference cavity;
  };
  mutable std::optional<Reference> reference_;
};

/// With the tissue, enough for the score without a recording.
struct FinishedHand {
  session::ScoreInput input;  // measured values of the hand, and the damage
  std::optional<session::ExploreMeter> explore;
  std::vector<ServoTick> unexplored;  // of an exploration, not yet evaluated
};
/// The same score as evaluate_session() of the recording. A second or more. Throws Error if tissue or ideal cannot be
/// built.
session::Score final_score(const Scene& scene, const haptics::TissueVolume& after, FinishedHand hand);

/// With its score, and the tissue rebuilt from the cuts.
struct EvaluatedSession {
  Scene scene;
  haptics::TissueVolume start, after;
  std::optional<haptics::TissueVolume> ideal;
  std::optional<session::Preparation> preparation;  // the compared tissues; empty for an exploration task
  session::ScoreInput input;
  session::Score score;
  // Of the session, in order, whose strokes were not undone; while the session lives.
  std::vector<const Cut*> cuts;
};
/// Throws Error if the tissue is missing or has changed.
EvaluatedSession evaluate_session(const session::SessionReader& session);
/// By the rules of `scene`, which otherwise equals the session's (scene_with).
EvaluatedSession evaluate_session(const session::SessionReader& session, Scene scene);

}  // namespace typodont
