// Plans strokes that cut the tissue to a task's ideal and spare the remaining tissue. Used by the expert hand and by
// tests of tasks.
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
  bool goes_on = false;  // the next stroke continues from the end of this stroke without a stop
  bool bulk = false;     // removes volume away from the final surface
};

/// The rotation that rotates T's z axis, the shank, to `axis_W`.
dquat toward(const dvec3& axis_W);

/// Plans strokes that remove the tissue outside the preparation's ideal: first the bulk, layer by layer from the
/// opening down; then, with `finish`, the floor and the walls. The head reaches at most `into` (m) into the ideal,
/// and the shank does not touch it. Strokes that would remove nothing are omitted. The shank points along the
/// preparation's axis. `step`: m between the passes along floor and walls. `around`: neighbours and gum, which the
/// head does not touch; null: no surroundings. `size`: ratio of the work's size to that of a tooth; distances between
/// positions and tolerances are multiplied by it. `least`: m, tissue that is thinner gets no strokes.
std::vector<Stroke> plan_strokes(const session::Preparation& preparation, const haptics::Tool& tool, double step,
                                 double into = 0, const SurroundingsShape* around = nullptr, bool finish = true,
                                 double size = 1, double least = 0);

/// Cuts the strokes out of the tissue without a servo. The result is that of a tool that follows the strokes exactly.
void carve_strokes(haptics::TissueVolume& volume, const haptics::Tool& tool, const std::vector<Stroke>& strokes);

}  // namespace typodont
