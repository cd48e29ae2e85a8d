// What is made of recorded sessions, beside the window: reports, learning curves, films, surfaces. Main thread.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// Recorded sessions and saved preparations anew, by the names their exercises have in this language.
void list_sessions(OperatorState& s);

/// Of a recording that ended just now, or was found; written beside it, into the state's outcome. `then`: afterwards.
void make_report(OperatorState& s, LongWork& work, const std::filesystem::path& recording,
                 std::function<void()> then = {});
/// The score of a session without a recording, into the state's outcome.
void make_score(OperatorState& s, LongWork& work, std::shared_ptr<const Unscored> of);
/// In the browser; made where there is none.
void show_report(OperatorState& s, LongWork& work, const SessionEntry& of);
/// Of all sessions beside this one.
void make_curve(OperatorState& s, LongWork& work, const SessionEntry& of);
void make_film(OperatorState& s, LongWork& work, const SessionEntry& of);
/// Of the tissue as it was left; OperatorState::mesh_format says as what.
void make_surface(OperatorState& s, LongWork& work, const SessionEntry& of);

}  // namespace typodont
