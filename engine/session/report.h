// Writes the report of a session as one HTML page. The page needs no network and no other files, and has styles for
// print, light mode and dark mode. Only the rotatable view of the result needs a script.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/session/cavity.h"
#include "engine/session/defect.h"
#include "engine/session/remarks.h"
#include "engine/session/result_model.h"
#include "engine/session/score.h"
#include "engine/session/session_file.h"
#include "engine/session/strings.h"
#include "engine/session/task.h"

namespace typodont::session {

/// A session's main results, for comparison with other sessions.
struct SessionSummary {
  std::string file, date, trainee, scene;
  bool truncated = false;
  Score score;
  TaskText title;  // title of the scene's task; empty: none
};

/// The result of checking a recording by replay.
struct Verification {
  // kOtherLaw: the recording was made with another force law, so its hand motion was replayed with the current law
  enum class State { kNotChecked, kIdentical, kDiffers, kOtherLaw } state = State::kNotChecked;
  std::string what;  // description of the first difference between recording and replay
  // Only for kOtherLaw. force_…: difference between recorded and replayed force, N. removed, removed_before: removed
  // volume in the replay and in the recording, m³.
  double force_rms = 0, force_max = 0, removed = 0, removed_before = 0;
};

/// Additional data for the report that is not in the session file: geometry, and other sessions for comparison.
struct ReportOptions {
  Language language = Language::kEnglish;
  Verification verification;
  std::vector<SessionPicture> more_pictures;  // pictures in addition to those in the session file
  std::optional<Score> score;                 // the score; if there is no value, score_session() computes it
  std::string not_measured;                   // why the tissue was not measured; empty: it was
  std::optional<ScoreInput> input;  // input of the score, if more measures are known than the session file contains
  // Final surface, with deviations from the ideal shape; the ideal shape's surface.
  std::optional<ResultModel> result, ideal;
  std::optional<Preparation> preparation;  // geometry from which sections are drawn
  std::vector<Remark> remarks;
  std::vector<Defect> defects;    // defects of the result, with the strokes that made them
  bool encloses_nothing = false;  // true: the tissue is an open surface, so that only the removed tissue has a volume
  std::vector<SessionSummary> earlier;  // earlier sessions with the same scene, oldest first
  std::optional<SessionSummary> expert;
};

/// Reads a PNG picture for a report or a session. Throws Error if the file is no PNG.
SessionPicture read_picture(const std::filesystem::path& png, std::string_view name, std::string_view title = "");

/// Returns the input of the score. The volumes come from the session's result. Without a result, the final volumes are
/// the initial volumes minus `removed`. `removed`: m³, volume of each tissue that the ticks removed.
ScoreInput score_input(const SessionReader& session, const HandMeasures& hand, const PerTissue& removed);
/// Computes the score by the rules of the session's scene, without the tissue. A task gets no points, because its shape
/// is not measured.
Score score_session(const SessionReader& session);

std::string report_html(const SessionReader& session, const ReportOptions& options = {});

/// The main results of a session. If `score` has no value, score_session() computes the score.
SessionSummary summarize(const SessionReader& session, std::optional<Score> score = {});

/// Writes a page about the sessions of one trainee. For each scene, it shows how the score and its main items changed
/// from session to session.
std::string learning_curve_html(std::span<const SessionSummary> sessions, Language language);

}  // namespace typodont::session
