// Neighbours in space next to each other in memory.
#pragma once

#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh {

/// Along a Z-order curve (Morton 1966) of centroids; vertices keep indices. Allocates.
TissueMesh in_spatial_order(TissueMesh mesh);

}  // namespace typodont::haptics::mesh
