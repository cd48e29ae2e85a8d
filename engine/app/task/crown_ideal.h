// Computes the ideal shape of a crown preparation from the tooth's surface.
#pragma once

#include "engine/app/scene/ideal.h"
#include "engine/app/tissue/tissue_edit.h"

namespace typodont {

/// Removes tissue from the tooth in `copy`. The chewing surface is lowered by the same depth everywhere; walls follow
/// the outline at the margin and lean inwards. `axis_W`: unit vector out of the tooth, along which the crown is placed.
void reduce_for_crown(const CrownReduction& crown, const dvec3& axis_W, DenseCopy& copy);

}  // namespace typodont
