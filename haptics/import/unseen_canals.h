// Estimates how much pulp lies in root canals that are too narrow for the voxels of a scan.
#pragma once

#include "haptics/dense_tissue.h"

namespace typodont::haptics::importing {

/// Returns the volume, in m³, that the root canals of a tooth can have without being seen in its scan. A root that
/// contains no pulp may contain such a canal along its whole length, so the volume is an upper limit for teeth with one
/// canal in each root. The function finds the roots in the slices across the longest edge of the tooth's box: a root is
/// a connected area of dentin without enamel. `diameter`: m, diameter of the widest canal that the scan does not show.
double unseen_canal_volume(const DenseTissue& tooth, double diameter);

}  // namespace typodont::haptics::importing
