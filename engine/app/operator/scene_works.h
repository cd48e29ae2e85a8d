// Creates the user's own exercises while the window continues: from a scan or mesh, or from the tissue that an author
// painted and drilled. Main thread.
#pragma once

#include <memory>

#include "engine/app/operator/choices.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/implant_planner.h"

namespace typodont {

/// Enters the file or folder that was dropped on the window into the import form, with a proposed name.
void take_dropped(OperatorState& s);

/// Imports with the settings in OperatorState::import, and selects the new scene.
void import_tooth(OperatorState& s, BackgroundTask& work, Choices& choices);
/// Saves `authored` with the settings in OperatorState::exercise, and selects the new scene. `authored` must live until
/// the work has ended.
void save_exercise(OperatorState& s, BackgroundTask& work, Choices& choices, Authored& authored);
/// Saves the plan in OperatorState::plan as an exercise, and selects the new scene on the start page.
void save_plan(OperatorState& s, BackgroundTask& work, Choices& choices, std::shared_ptr<const ImplantPlanner> planner);
/// At the program's end: saves immediately, under a name that contains the exercise's name and the date, so that no
/// file is replaced. Returns the file. Throws Error.
std::filesystem::path keep_exercise(const OperatorState& s, const Authored& authored);

}  // namespace typodont
