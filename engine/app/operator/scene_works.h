// Exercises of one's own, made beside the window: from a scan or mesh, and from what an author painted and drilled.
// Main thread.
#pragma once

#include "engine/app/operator/choices.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// The file or folder that was let fall on the window stands in the form, with a name for it.
void take_dropped(OperatorState& s);

/// As OperatorState::import says; chosen once it is there.
void bring_in(OperatorState& s, LongWork& work, Choices& choices);
/// As OperatorState::exercise says, of what was authored, which stays until the work has ended; chosen once it is
/// there.
void save_exercise(OperatorState& s, LongWork& work, Choices& choices, Authored& authored);
/// At the program's end, at once: under the exercise's name and the date, so that it replaces none. Its file. Throws
/// Error.
std::filesystem::path keep_exercise(const OperatorState& s, const Authored& authored);

}  // namespace typodont
