// Writes an implant plan as an exercise: scene, tissue, instruments, steps.
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

/// Writes the exercise, after the checks that a session makes at its start. If the jaw's tissue is a volume, copies the
/// part up to 15 mm from the implant to a .vdb beside the scene, with voxels of at most 0.15 mm, and moves it so that
/// the implant's top is where the display rigs look. `over`: which files may be replaced (never the jaw's volume).
/// Throws Error, also if the implant leaves the bone, or Cancelled; then nothing has changed.
void write_planned_exercise(const PlannedExercise& exercise, const std::filesystem::path& file, Over over,
                            Progress& progress);
/// Throws the same Error as write_planned_exercise() if a file of the exercise must not be written.
void require_planned_exercise(const Scene& scene, const std::filesystem::path& file, Over over);

}  // namespace typodont
