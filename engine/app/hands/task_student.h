// Hands that know a task's ideal: where to put the head so that it takes away what should go and nothing else. For the
// expert hand, and for tests of tasks.
#pragma once

#include <vector>

#include "engine/app/surroundings/surroundings.h"
#include "engine/session/cavity.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// A straight movement of the head.
struct Stroke {
  Pose from, to;
  bool goes_on = false;  // the next stroke begins where this one ends, without a stop
  bool bulk = false;     // removes volume away from the final surface
};

/// Turns T's z, the shank, to the axis.
dquat toward(const dvec3& axis_W);

/// Strokes from the opening down that take away what the preparation's ideal does not leave: layer by layer the bulk,
/// then the floor, then the walls. Head and shank stay clear of what the ideal leaves, or the head reaches no more than
/// `into` (m) into it. A stroke is left out where those before it leave nothing for it to take. The shank points along
/// the preparation's axis. `step`: m between the passes along floor and walls. `around`: neighbours and gum, which the
/// head keeps off; null: there are none.
std::vector<Stroke> plan_strokes(const session::Preparation& preparation, const haptics::Tool& tool, double step,
                                 double into = 0, const SurroundingsShape* around = nullptr, bool finish = true);

/// Takes the strokes out of the tissue as they are, without a servo: what a hand of endless patience would leave.
void carve_strokes(haptics::TissueVolume& volume, const haptics::Tool& tool, const std::vector<Stroke>& strokes);

}  // namespace typodont
