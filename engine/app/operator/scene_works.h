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

/// Enters the file or folder that was dropped on the window into the import form, with a proposed name. True if it is a
/// scan, which can be shown before its import.
bool take_dropped(OperatorState& s);
/// If a mesh was dropped on the scan page: enters it into the form of the fusion, and returns true.
bool take_dropped_mesh(OperatorState& s);
/// Enters a name for the exercise, from the file of the import form.
void propose_name(OperatorState& s);
/// The import that the form describes.
NewTooth tooth_of(const ImportForm& form);

/// Imports with the settings in OperatorState::import, and selects the new scene.
void import_tooth(OperatorState& s, BackgroundTask& work, Choices& choices);
/// Makes an exercise of a scan's region with its corrections, and selects the new scene.
void import_reviewed(OperatorState& s, BackgroundTask& work, Choices& choices, const ScanReview& review);
/// Saves `authored` with the settings in OperatorState::exercise, and selects the new scene. `authored` must live until
/// the work has ended.
void save_exercise(OperatorState& s, BackgroundTask& work, Choices& choices, Authored& authored);
/// Saves the plan in OperatorState::plan as an exercise, and selects the new scene on the start page.
void save_plan(OperatorState& s, BackgroundTask& work, Choices& choices, std::shared_ptr<const ImplantPlanner> planner);
/// At the program's end: saves immediately, under a name that contains the exercise's name and the date, so that no
/// file is replaced. Returns the file. Throws Error.
std::filesystem::path keep_exercise(const OperatorState& s, const Authored& authored);

}  // namespace typodont
