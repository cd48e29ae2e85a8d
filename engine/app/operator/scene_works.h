// Makes the user's exercises in the background: from a scan, a mesh, or a scene from authoring mode. Main thread only.
#pragma once

#include <string>
#include <vector>

#include "engine/app/operator/choices.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/session_desk.h"
#include "engine/app/operator/state.h"

namespace typodont {

/// The file names as one text, separated by semicolons.
std::string joined_files(const std::vector<std::string>& files);
/// Enters a dropped file, folder or set of meshes in the import form, and proposes a name. True: it is a scan that can
/// be shown before its import.
bool take_dropped(OperatorState& s);
/// Takes a mesh dropped on the scan page to the fusion page. True: it was a mesh.
bool take_dropped_mesh(OperatorState& s);
/// Proposes a name for the file in the import form.
void propose_name(OperatorState& s);
/// Converts the import form to the arguments of import_tooth().
NewTooth tooth_of(const ImportForm& form);

/// Imports a tooth with the settings in OperatorState::import, and selects the new scene.
void import_tooth(OperatorState& s, BackgroundTask& work, Choices& choices);
/// Imports the region of the scan with the user's corrections, and selects the new scene.
void import_reviewed(OperatorState& s, BackgroundTask& work, Choices& choices, const ScanReview& review);
/// Makes a case in another process, and selects it: the next one of the trainee's path, or that of
/// OperatorState::cases. The user sees the reason for the next case.
void begin_case(OperatorState& s, BackgroundTask& work, Choices& choices, bool next);
/// Saves the exercise that OperatorState::exercise describes, and selects its scene. `authored` must outlive the work.
void save_exercise(OperatorState& s, BackgroundTask& work, Choices& choices, Authored& authored);
/// Saves OperatorState::plan as an exercise, and selects this exercise on the start page.
void save_plan(OperatorState& s, BackgroundTask& work, Choices& choices);
/// Saves the scene edited in authoring mode when the program ends. The name contains the date, so no file is replaced.
/// Throws Error.
std::filesystem::path keep_exercise(const OperatorState& s, const Authored& authored);

}  // namespace typodont
