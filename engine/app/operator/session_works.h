// Reports, learning curves, films and surfaces in the background. Main thread only.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// Recordings and preparations; titles in the window's language.
void list_sessions(OperatorState& s);

/// Beside the recording, and into the state's outcome; then `then`.
void make_report(OperatorState& s, BackgroundTask& work, const std::filesystem::path& recording,
                 std::function<void()> then = {});
/// Of a session without recording, into the state's outcome.
void make_score(OperatorState& s, BackgroundTask& work, std::shared_ptr<const Unscored> of);
/// In the browser; made first if missing.
void show_report(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// Of all sessions in this one's folder, in the browser.
void make_curve(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
void make_film(OperatorState& s, BackgroundTask& work, const SessionEntry& of);
/// In OperatorState::mesh_format.
void make_surface(OperatorState& s, BackgroundTask& work, const SessionEntry& of);

}  // namespace typodont
