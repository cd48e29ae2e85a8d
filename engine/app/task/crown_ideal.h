// Computes the ideal shape of a crown preparation from the tooth's surface.
#pragma once

#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/json.h"

namespace typodont {

/// Dimensions of a crown preparation, m.
struct CrownReduction {
  double margin_height = 0;   // height of the chamfer's margin along the axis
  double chamfer = 0;         // depth of the cut at the chamfer; above the chamfer, at least this depth is cut
  double chamfer_radius = 0;  // chamfer's radius, equal to that of the bur's end
  double taper = 0;           // rad, total convergence: twice the angle between wall and axis
  double occlusal = 0;        // depth below the uncut chewing surface
  double edge_radius = 0;     // radius of the rounded edges between the surfaces
};

/// Reads the object `crown` of an ideal shape. Throws Error.
CrownReduction read_crown_reduction(const Json& json);

/// Removes tissue from the tooth in `copy`. The chewing surface is lowered by the same depth everywhere; walls follow
/// the outline at the margin and lean inwards. `axis_W`: unit vector out of the tooth, along which the crown is placed.
void reduce_for_crown(const CrownReduction& crown, const dvec3& axis_W, DenseCopy& copy);

}  // namespace typodont
