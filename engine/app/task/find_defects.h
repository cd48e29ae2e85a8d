// Finds the strokes of a recording that caused the defects of its result: applies the recorded cuts again to the voxels
// that differ from the target shape ("ideal").
#pragma once

#include <vector>

#include "engine/app/task/task.h"
#include "engine/session/defect.h"

namespace typodont {

/// Returns the defects in order of time. Takes a fraction of a second, and as much memory as the compared tissues.
std::vector<session::Defect> find_defects(const session::SessionReader& session, const EvaluatedSession& judged);

}  // namespace typodont
