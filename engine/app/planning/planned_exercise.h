// Writes an implant exercise from a plan. The exercise is a scene with the tissue around the implant, and with the
// instruments and steps of the procedure.
#pragma once

#include <filesystem>
#include <string>

#include "engine/app/planning/implant_planner.h"
#include "engine/base/progress.h"

namespace typodont {

struct PlannedExercise {
  std::string name;
  const ImplantPlanner* planner = nullptr;
  ImplantProcedure procedure;
  session::ImplantPlan plan;
};

/// Writes the scene `file` after checking it as a session would do. If the tissue is a volume, the part within 15 mm
/// around the implant is copied, with voxels of at most 0.15 mm. The copy is moved so that the planned platform is at
/// the point that the rigs show, and written beside the scene with the extension .vdb. Other tissue stays as the
/// planner's scene defines it. Replaces only files that it has written earlier. Throws Error (also if the implant
/// leaves the bone) or Cancelled; then nothing has changed.
void write_planned_exercise(const PlannedExercise& exercise, const std::filesystem::path& file, Progress& progress);

}  // namespace typodont
