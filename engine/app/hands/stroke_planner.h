// Plans strokes that cut the tissue down to a task's ideal shape. Used by the expert hand and by tests.
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
  bool goes_on = false;  // true: continues with the next stroke without a stop
  bool bulk = false;     // true: the stroke removes volume away from the final surface
  bool in_air = false;   // true: connection between two passes, without contact
};

struct StrokePlan {
  std::vector<Stroke> strokes;
  session::DenseField left;  // tissue that is left if the strokes are followed exactly, on the preparation's grid
};

struct StrokeOptions {
  double step = 0;                            // m, distance between two passes along floor and walls
  double into = 0;                            // m, depth to which the head may enter the ideal shape
  const SurroundingsShape* around = nullptr;  // neighbouring teeth and gum; may be null
  double clearance = 0;                       // m, smallest distance of the head from neighbouring teeth and gum
  bool finish = true;                         // true: after the bulk, also floor and walls
  double size = 1;   // factor for grid distances and tolerances; 1 for a tooth, larger for a larger object
  double least = 0;  // m; no strokes are planned for thinner tissue
};

/// The rotation that turns the tool's z axis (its shank) to the direction `axis_W`.
dquat toward(const dvec3& axis_W);

/// Plans strokes that remove the tissue outside the ideal shape: the bulk, layer by layer from the opening down; if
/// `options.finish` is true, then the floor and the walls. Strokes that would remove nothing are left out. The shank is
/// parallel to the preparation's axis and does not touch the ideal shape.
///   `preparation`: its ideal shape must have true distances (session::redistanced). In air, distances before the
///   work may be smaller than the true ones, but not larger.
StrokePlan plan_strokes(const session::Preparation& preparation, const haptics::Tool& tool,
                        const StrokeOptions& options);

/// Removes the volume of the strokes from the tissue without a servo, as if a tool followed the strokes exactly.
void carve_strokes(haptics::TissueVolume& volume, const haptics::Tool& tool, const std::vector<Stroke>& strokes);

}  // namespace typodont
