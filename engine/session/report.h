// A session as one self-contained HTML page: no network, prints well, readable in light and dark. Only the turnable
// view of the result has a script; everything else is there without.
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

/// One session among others.
struct SessionSummary {
  std::string file, date, trainee, scene;
  bool truncated = false;
  Score score;
  TaskText title;  // of the scene's task; empty where it has none
};

/// What is known of the recording's truth when a report is made.
struct Verification {
  enum class State { kNotChecked, kIdentical, kDiffers } state = State::kNotChecked;
  std::string what;  // differs, in words
};

/// What the program knows beyond the file: geometry, and other sessions to compare with.
struct ReportOptions {
  Language language = Language::kEnglish;
  Verification verification;
  std::vector<SessionPicture> more_pictures;  // beside those inside the session
  std::optional<Score> score;                 // nothing: scored by score_session()
  std::optional<ScoreInput> input;            // what was scored, where more was measured than the file holds
  std::optional<ResultModel> result, ideal;   // the surface that was left, with how far it is off; the ideal's
  std::optional<Preparation> preparation;     // for sections through it
  bool encloses_nothing = false;              // the tissue is an open surface: only what was removed has a volume
  std::vector<SessionSummary> earlier;        // of the same scene, oldest first
  std::optional<SessionSummary> expert;
};

/// Reads a PNG for a report or a session. Throws Error when the file is not one.
SessionPicture read_picture(const std::filesystem::path& png, std::string_view name, std::string_view title = "");

/// Volumes, hand and result of a session, as far as they are in it. Without a result the volumes after are those before
/// less what the ticks removed.
ScoreInput score_input(const SessionReader& session);
/// By the rules in the session's own scene.
Score score_session(const SessionReader& session);

std::string report_html(const SessionReader& session, const ReportOptions& options = {});

/// `score`: nothing: scored by score_session().
SessionSummary summarize(const SessionReader& session, std::optional<Score> score = {});

/// A trainee's sessions as one page: how the score and what counts in it went, scene by scene, in the order of dates.
std::string learning_curve_html(std::span<const SessionSummary> sessions, Language language);

}  // namespace typodont::session
