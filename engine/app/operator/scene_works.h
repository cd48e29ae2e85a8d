// The user's own exercises in the background: from a scan, a mesh, or an author's work. Main thread only.
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

/// Separated by semicolons.
std::string joined_files(const std::vector<std::string>& files);
/// Dropped file, folder or meshes into the import form, with a proposed name. True: a scan that can be shown first.
bool take_dropped(OperatorState& s);
/// A mesh dropped on the scan page goes to the fusion page: true.
bool take_dropped_mesh(OperatorState& s);
/// From the file in the import form.
void propose_name(OperatorState& s);
/// Converts the import form to the arguments of import_tooth().
NewTooth tooth_of(const ImportForm& form);

/// By OperatorState::import; selects the new scene.
void import_tooth(OperatorState& s, BackgroundTask& work, Choices& choices);
/// From the scan's region with the corrections; selects the new scene.
void import_reviewed(OperatorState& s, BackgroundTask& work, Choices& choices, const ScanReview& review);
/// By OperatorState::exercise; selects the new scene. `authored` must outlive the work.
void save_exercise(OperatorState& s, BackgroundTask& work, Choices& choices, Authored& authored);
/// OperatorState::plan as an exercise, selected on the start page.
void save_plan(OperatorState& s, BackgroundTask& work, Choices& choices, std::shared_ptr<const ImplantPlanner> planner);
/// At the program's end, under a name with the date, which replaces nothing. Throws Error.
std::filesystem::path keep_exercise(const OperatorState& s, const Authored& authored);

}  // namespace typodont
