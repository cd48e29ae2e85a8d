// A scene's task and its tissue in one place: the start and the ideal as volumes, and a result judged against them.
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

/// The tissue as the task wants it left; nothing where the task names no ideal. `start`: load_tissue(scene). Throws
/// Error.
std::optional<haptics::TissueVolume> ideal_tissue(const Scene& scene, const haptics::TissueVolume& start);

/// Judges results of one scene. Holds copies: what it was made from may change. One thread at a time.
class TaskJudge {
 public:
  /// Throws Error where the task's ideal cannot be made.
  TaskJudge(const Scene& scene, const haptics::TissueVolume& start);

  bool has_ideal() const { return ideal_.has_value(); }
  const haptics::TissueVolume* ideal() const { return ideal_ ? &*ideal_ : nullptr; }

  /// Adds to `input` what the geometry of `after` says, and returns what it was read from (not of a task that is to
  /// explore). About a second for a tooth.
  std::optional<session::Preparation> judge(const haptics::TissueVolume& after, session::ScoreInput& input) const;
  /// The three states on common voxels, as far as anything was or should have been changed.
  session::Preparation preparation(const haptics::TissueVolume& after) const;
  /// For a task that is to explore; feed it the ticks and put its result into the score's input.
  std::optional<session::ExploreMeter> explore_meter() const;

 private:
  haptics::TissueVolume start_;
  std::optional<haptics::TissueVolume> ideal_;
  std::optional<session::Task> task_;
  std::vector<std::unique_ptr<haptics::Solid>> protect_, region_;
};

/// What is known of the hand once a session is over, recorded or not: all that a score needs beside the tissue.
struct FinishedHand {
  session::ScoreInput input;  // hand, damage
  std::optional<session::ExploreMeter> explore;
  std::vector<ServoTick> unexplored;  // ticks that came before there was a meter
};
/// How a finished session is scored, without what the report shows beside it: the same as judge_session() of its
/// recording. Takes a second or more. Throws Error where the scene's tissue or its ideal cannot be made.
session::Score final_score(const Scene& scene, const haptics::TissueVolume& after, FinishedHand hand);

/// Everything known of a recorded session: its tissue made again from its cuts, and what that scores.
struct JudgedSession {
  Scene scene;
  haptics::TissueVolume start, after;
  std::optional<haptics::TissueVolume> ideal;
  std::optional<session::Preparation> preparation;  // not of a task that is to explore
  session::ScoreInput input;
  session::Score score;
};
/// Throws Error where the tissue is not there or has changed.
JudgedSession judge_session(const session::SessionReader& session);
/// The same by the rules of `scene`, which is the session's own but for these (scene_with).
JudgedSession judge_session(const session::SessionReader& session, Scene scene);

}  // namespace typodont
