// Creates reports, learning curves, films and surfaces from recorded sessions, while the window continues. Main thread.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// Lists the recorded sessions and saved preparations again, with the titles of their exercises in this language.
void list_sessions(OperatorState& s);

/// Writes the report of a recording beside the recording, and stores the result in the state's outcome. Calls `then`
/// afterwards.
void make_report(OperatorState& s, BackgroundTask& work, const std::filesystem::path& recording,
                 std::function<void()> then = {});
/// Computes the score of a session without a recording, and stores it in the state's outcome.
void make_score(OperatorState& s, BackgroundTask& work, std::shared_ptr<const Unscored> of);
/// Shows the report in the browser; creates it first if necessary.
void show_report(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Writes and shows the learning curve for all sessions in the folder of this session.
void make_curve(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
void make_film(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Writes the final tissue as a surface in the format OperatorState::mesh_format.
void make_surface(OperatorState& s, BackgroundTask& work, const SessionEntry& of);

}  // namespace typodont
