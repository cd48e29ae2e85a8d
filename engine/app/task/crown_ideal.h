// A crown preparation's ideal, computed from the tooth's surface.
#pragma once

#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/json.h"

namespace typodont {

/// m.
struct CrownReduction {
  double margin_height = 0;   // of the chamfer, along the axis
  double chamfer = 0;         // below the outline; least depth of the walls
  double chamfer_radius = 0;  // of the section: the bur's round end
  double taper = 0;           // rad, total: twice the angle of wall and axis
  double occlusal = 0;        // below the uncut surface
  double edge_radius = 0;     // radius of the rounded edges between the surfaces
};

/// Object `crown` of an ideal. Throws Error.
CrownReduction read_crown_reduction(const Json& json);

/// `axis_W`: unit vector out of the tooth, the crown's path. The chewing surface moves in by the same depth everywhere;
/// walls follow the outline at the margin and lean inwards.
void reduce_for_crown(const CrownReduction& crown, const dvec3& axis_W, DenseCopy& copy);

}  // namespace typodont
