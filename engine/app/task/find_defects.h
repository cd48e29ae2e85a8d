// Finds the strokes of a recording that caused the defects of its result: applies the recorded cuts again to the voxels
// that differ from the target shape ("ideal").
#pragma once

#include <vector>

#include "engine/app/task/task.h"
#include "engine/session/defect.h"

namespace typodont {

/// In order of time. A fraction of a second; needs the memory of the compared tissues again.
std::vector<session::Defect> find_defects(const session::SessionReader& session, const EvaluatedSession& judged);

}  // namespace typodont
