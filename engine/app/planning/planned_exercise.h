// Writes an implant exercise from a plan. The exercise is a scene with the tissue around the implant, and with the
// instruments and steps of the procedure.
#pragma once

#include <filesystem>
#include <string>

#include "engine/app/planning/implant_planner.h"
#include "engine/base/partial_file.h"
#include "engine/base/progress.h"

namespace typodont {

struct PlannedExercise {
  std::string name;
  const ImplantPlanner* planner = nullptr;
  ImplantProcedure procedure;
  session::ImplantPlan plan;
};

/// Checks the scene as a session would do, and writes it to `file`. If the tissue is a volume, the part within 15 mm
/// around the implant is copied, with voxels of at most 0.15 mm. The copy is moved, so that the planned platform
/// (implant's upper end) is at the point that the display rigs show. The copy is written beside the scene, with the
/// extension .vdb. Other tissue stays as the planner's scene defines it. `over` states whether files that this process
/// has read may be replaced; the planner's own volume is never replaced. Throws Error (also if the implant leaves the
/// bone) or Cancelled; then nothing has changed.
void write_planned_exercise(const PlannedExercise& exercise, const std::filesystem::path& file, Over over,
                            Progress& progress);
/// Throws the Error that write_planned_exercise() would throw if it may not write its files.
void require_planned_exercise(const Scene& scene, const std::filesystem::path& file, Over over);

}  // namespace typodont
