// Writes an implant exercise from a plan: a scene with the site's tissue, and with the procedure's instruments and
// steps.
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

/// Writes the scene `file`, after checking it as a session would. Tissue from a volume is cut to the site (15 mm
/// around the implant), sampled with voxels of at most 0.15 mm, and moved so that the planned platform is at the
/// point that the rigs show; it is written beside the scene, with the extension .vdb. Other tissue stays as the
/// planner's scene defines it. Replaces only its own earlier results. Throws Error (also if the implant leaves the
/// bone) or Cancelled; then nothing has changed.
void write_planned_exercise(const PlannedExercise& exercise, const std::filesystem::path& file, Progress& progress);

}  // namespace typodont
