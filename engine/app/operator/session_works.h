// Makes reports, learning curves, films, surfaces and experiments in the background. Main thread only.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"
#include "engine/session/report.h"

namespace typodont {

/// Draws the final surface on the CPU, on the window's background. If there is an ideal shape, colours show the
/// difference from this shape. Empty if the surface is unknown. Any thread.
render::Picture picture_of_result(const session::ReportOptions& report);

/// Lists recordings and saved preparations, with titles in the window's language.
void list_sessions(OperatorState& s);

/// Writes the report beside the recording, and the result to OperatorState::outcome. Then calls `then`.
void make_report(OperatorState& s, BackgroundTask& work, const std::filesystem::path& recording,
                 std::function<void()> then = {});
/// Scores an unrecorded session. Writes the result to OperatorState::outcome.
void make_score(OperatorState& s, BackgroundTask& work, std::shared_ptr<const Unscored> of);
/// Shows the report in the browser; makes it if missing.
void show_report(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Makes the learning curve of all sessions in this session's folder, and shows it in the browser.
void make_curve(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
void make_film(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Exports the final surface in the format OperatorState::mesh_format.
void make_surface(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Runs the experiment of OperatorState::experiment with the selected exercise and hand in a separate process. Writes
/// the trials to ~/Typodont/experiments/PERSON/DATE_QUESTION.csv, the result to the .html file beside it and to the
/// state.
void make_experiment(OperatorState& s, BackgroundTask& work);

}  // namespace typodont
