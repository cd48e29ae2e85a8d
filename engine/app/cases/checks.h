// Checks whether a case can be solved, and whether a careless hand fails.
#pragma once

#include "engine/app/cases/draft.h"
#include "engine/app/scene.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Scores the exact plan, the careless hand and `hands`; stores the points in `result`. `R`: the cavity's axes in frame
/// W. Throws RunFailure if the exact plan gets too few points or makes a critical error, or the careless hand gets too
/// many points; Error if `hands` are given for a task without an ideal shape.
void grade(Case& result, const Json& text, const Scene& scene, const glm::dmat3& R, const haptics::TissueVolume& start,
           const std::vector<HandErrors>& hands);

}  // namespace typodont
