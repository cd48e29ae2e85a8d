// Hands that know a task's ideal: where to put the head so that it takes away what should go and nothing else. For the
// expert hand, and for tests of tasks.
#pragma once

#include <vector>

#include "engine/session/cavity.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// A straight movement of the head.
struct Stroke {
  Pose from, to;
};

/// Turns T's z, the shank, to the axis.
dquat toward(const dvec3& axis_W);

/// Strokes from the opening down, layer by layer, row by row and across, each as long as the head stays clear of what
/// the ideal leaves, or reaches no more than `into` (m) into it. The shank points along the preparation's axis. `step`:
/// m between rows and layers.
std::vector<Stroke> plan_strokes(const session::Preparation& preparation, const haptics::Tool& tool, double step,
                                 double into = 0);

/// Takes the strokes out of the tissue as they are, without a servo: what a hand of endless patience would leave.
void carve_strokes(haptics::TissueVolume& volume, const haptics::Tool& tool, const std::vector<Stroke>& strokes);

}  // namespace typodont
