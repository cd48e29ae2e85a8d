// The ideal shape of a task, as the scene states it; engine/app/task/task.h builds its tissue.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont {

/// Dimensions of a crown preparation, m.
struct CrownReduction {
  double margin_height = 0;   // height of the chamfer's margin along the axis
  double chamfer = 0;         // depth of the cut at the chamfer; above the chamfer, at least this depth is cut
  double chamfer_radius = 0;  // chamfer's radius, equal to that of the bur's end
  double taper = 0;           // rad, total convergence: twice the angle between wall and axis
  double occlusal = 0;        // depth below the uncut chewing surface
  double edge_radius = 0.4 * kMillimetre;  // radius of the rounded edges between the surfaces
};

/// The target shape as the scene states it. One of `volume`, `session`, `mesh`, `unprepared` and `crown`, or solids.
struct Ideal {
  std::optional<Json> volume, session, mesh;  // names of files
  double mesh_unit = kMillimetre;             // m, one unit of the mesh's file
  bool unprepared = false;
  std::optional<CrownReduction> crown;
  std::vector<std::unique_ptr<haptics::Solid>> remove, keep;
  std::vector<Tissue> remove_tissue;
  double grow = 0;  // m
};

/// Declares the keys of the ideal shape. Throws Error.
void describe_ideal(Keys& keys, Ideal& ideal, const haptics::SolidFiles& files);

}  // namespace typodont
