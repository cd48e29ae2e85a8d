// Makes reports, learning curves, films and surfaces from recorded sessions in the background. Main thread only.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// Updates the list of recorded sessions and saved preparations. The titles of their exercises are in the window's
/// language.
void list_sessions(OperatorState& s);

/// Writes the report of a recording to a file beside it, and stores the result in the state's outcome. Then calls
/// `then`.
void make_report(OperatorState& s, BackgroundTask& work, const std::filesystem::path& recording,
                 std::function<void()> then = {});
/// Computes the score of a session that has no recording, and stores it in the state's outcome.
void make_score(OperatorState& s, BackgroundTask& work, std::shared_ptr<const Unscored> of);
/// Shows the report in the browser. Creates the report first if it does not exist.
void show_report(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Writes the learning curve of all sessions in the folder of this session, and shows it in the browser.
void make_curve(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
void make_film(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Writes the final tissue as a surface file in the format of OperatorState::mesh_format.
void make_surface(OperatorState& s, BackgroundTask& work, const SessionEntry& of);

}  // namespace typodont
