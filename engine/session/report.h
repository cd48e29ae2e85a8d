// Writes a session as one self-contained HTML page that needs no network, for print, light and dark mode. Only the
// rotatable view of the result needs a script.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/session/cavity.h"
#include "engine/session/result_model.h"
#include "engine/session/score.h"
#include "engine/session/session_file.h"
#include "engine/session/strings.h"
#include "engine/session/task.h"

namespace typodont::session {

/// Summary of a session, for comparison with other sessions.
struct SessionSummary {
  std::string file, date, trainee, scene;
  bool truncated = false;
  Score score;
  TaskText title;  // title of the scene's task; empty if the task has no title
};

/// Result of the replay check of a recording.
struct Verification {
  enum class State { kNotChecked, kIdentical, kDiffers } state = State::kNotChecked;
  std::string what;  // description of the difference
};

/// Additional input that is not in the session file: geometry, and other sessions for comparison.
struct ReportOptions {
  Language language = Language::kEnglish;
  Verification verification;
  std::vector<SessionPicture> more_pictures;  // pictures in addition to those in the session
  std::optional<Score> score;                 // no value: score_session() computes it
  std::optional<ScoreInput> input;            // input of the score, if it contains more measures than the session file
  std::optional<ResultModel> result, ideal;   // final surface with its deviation; surface of the ideal
  std::optional<Preparation> preparation;     // geometry for the drawings of sections
  bool encloses_nothing = false;              // true if the tissue is an open surface: only removed tissue has a volume
  std::vector<SessionSummary> earlier;        // earlier sessions with the same scene, oldest first
  std::optional<SessionSummary> expert;
};

/// Reads a PNG for a report or a session. Throws Error if the file is not a PNG.
SessionPicture read_picture(const std::filesystem::path& png, std::string_view name, std::string_view title = "");

/// Volumes, hand measures and result of a session, as far as the session contains them. Without a result, the final
/// volumes are the initial volumes minus the removed volumes in the ticks.
ScoreInput score_input(const SessionReader& session);
/// Computes the score by the rules in the session's scene.
Score score_session(const SessionReader& session);

std::string report_html(const SessionReader& session, const ReportOptions& options = {});

/// Makes a summary. If `score` has no value, score_session() computes the score.
SessionSummary summarize(const SessionReader& session, std::optional<Score> score = {});

/// A trainee's sessions as one page. For each scene separately, it shows the development of the score and of its main
/// items over time.
std::string learning_curve_html(std::span<const SessionSummary> sessions, Language language);

}  // namespace typodont::session
