// Sorts triangles so that neighbours are near in memory.
#pragma once

#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh {

/// Sorts triangles along a Z-order curve (Morton 1966) of their centroids; vertices keep their indices. Allocates.
TissueMesh in_spatial_order(TissueMesh mesh);

}  // namespace typodont::haptics::mesh
