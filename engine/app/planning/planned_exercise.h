// A plan as an exercise: scene, tissue around the implant, instruments, steps.
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

/// Checked as by a session. A volume is copied within 15 mm, voxels of at most 0.15 mm, platform where the rigs look,
/// as .vdb beside the scene. `over`: whether read files may be replaced (never the planner's volume). Throws Error,
/// also if the implant leaves bone, or Cancelled, with nothing changed.
void write_planned_exercise(const PlannedExercise& exercise, const std::filesystem::path& file, Over over,
                            Progress& progress);
/// Throws the Error of write_planned_exercise() if its files may not be written.
void require_planned_exercise(const Scene& scene, const std::filesystem::path& file, Over over);

}  // namespace typodont
