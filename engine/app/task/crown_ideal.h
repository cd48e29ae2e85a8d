// The ideal result of a crown preparation, which is computed from the tooth's own surface.
#pragma once

#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/json.h"

namespace typodont {

/// Dimensions of a crown preparation, m.
struct CrownReduction {
  double margin_height = 0;   // lowest height of the chamfer (rounded step) along the preparation's axis
  double chamfer = 0;         // depth of the chamfer (rounded step) below the tooth's outline; least depth of the walls
  double chamfer_radius = 0;  // radius of the chamfer's section: the radius of the bur's round end
  double taper = 0;           // rad, total occlusal convergence: twice the angle between a wall and the axis
  double occlusal = 0;        // depth of the preparation below the uncut occlusal surface
  double edge_radius = 0;     // radius of the rounded edges between the surfaces
};

/// Reads the JSON object `crown` of an ideal result. Throws Error.
CrownReduction read_crown_reduction(const Json& json);

/// Changes the tissue to the preparation. `axis_W`: unit vector that points out of the tooth, parallel to the path on
/// which the crown is put on. The chewing surface moves inwards by the same depth everywhere, so the preparation
/// follows its cusps and hollows. The walls follow the outline of the tooth at the margin and lean inwards.
void reduce_for_crown(const CrownReduction& crown, const dvec3& axis_W, DenseCopy& copy);

}  // namespace typodont
