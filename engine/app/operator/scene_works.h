// Creates the user's own exercises in the background: from a scan or mesh, or from the tissue that an author painted
// and drilled. Main thread only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/app/operator/choices.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/implant_planner.h"

namespace typodont {

/// Joins the names of dropped files to one text, with semicolons between them.
std::string joined_files(const std::vector<std::string>& files);
/// If the user dropped a file, a folder or several meshes of one mouth on the window, enters their paths into the
/// import form and proposes a name. Returns true if the user dropped a scan, which can be shown before its import.
bool take_dropped(OperatorState& s);
/// If the user dropped a mesh on the scan page, enters it into the form of the fusion page and returns true.
bool take_dropped_mesh(OperatorState& s);
/// Proposes a name for the exercise, made from the file name in the import form.
void propose_name(OperatorState& s);
/// Converts the import form to the arguments of import_tooth().
NewTooth tooth_of(const ImportForm& form);

/// Imports a tooth with the settings in OperatorState::import, and selects the new scene.
void import_tooth(OperatorState& s, BackgroundTask& work, Choices& choices);
/// Makes an exercise from the selected region of the scan, with the user's corrections, and selects the new scene.
void import_reviewed(OperatorState& s, BackgroundTask& work, Choices& choices, const ScanReview& review);
/// Saves the author's work with the settings in OperatorState::exercise, and selects the new scene. `authored` must
/// exist until the work has ended.
void save_exercise(OperatorState& s, BackgroundTask& work, Choices& choices, Authored& authored);
/// Saves the plan in OperatorState::plan as an exercise, and selects the new scene on the start page.
void save_plan(OperatorState& s, BackgroundTask& work, Choices& choices, std::shared_ptr<const ImplantPlanner> planner);
/// Saves the author's work immediately when the program ends. The name contains the exercise's name and the date, so
/// that no file is replaced. Returns the file. Throws Error.
std::filesystem::path keep_exercise(const OperatorState& s, const Authored& authored);

}  // namespace typodont
