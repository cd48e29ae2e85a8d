// Plans strokes that cut the tissue down to a task's ideal (the tissue that must remain) and spare the remaining
// tissue. Used by the expert hand and by tests.
#pragma once

#include <vector>

#include "engine/app/surroundings/surroundings.h"
#include "engine/session/cavity.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// A straight motion of the tool's head.
struct Stroke {
  Pose from, to;
  bool goes_on = false;  // true: after this stroke, the tool continues with the next stroke without a stop
  bool bulk = false;     // true: the stroke removes volume away from the final surface
  bool in_air = false;   // true: a connection between two passes on which the head meets no tissue
};

/// Returns the rotation that turns the tool's z axis (its shank) to the direction `axis_W`.
dquat toward(const dvec3& axis_W);

/// Plans strokes that remove the tissue outside the preparation's ideal (the tissue that must remain). First it plans
/// the bulk, layer by layer from the opening down. If `finish` is true, it then plans the floor and the walls. Strokes
/// that would remove nothing are omitted. The shank is parallel to the preparation's axis and does not touch the ideal.
/// `into`: m, depth to which the head may enter the ideal. `step`: m, distance between two passes along floor and
/// walls. `around`: neighbouring teeth and gum, which the head must not touch; null: there are none. `size`: factor for
/// grid distances and tolerances, 1 for a tooth, larger for a larger body. `least`: m; no strokes are planned for
/// tissue that is thinner than this.
std::vector<Stroke> plan_strokes(const session::Preparation& preparation, const haptics::Tool& tool, double step,
                                 double into = 0, const SurroundingsShape* around = nullptr, bool finish = true,
                                 double size = 1, double least = 0);

/// Removes the volume of the strokes from the tissue without a servo, as if a tool followed the strokes exactly.
void carve_strokes(haptics::TissueVolume& volume, const haptics::Tool& tool, const std::vector<Stroke>& strokes);

}  // namespace typodont
