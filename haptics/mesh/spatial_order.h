// Sorts triangles so that neighbours in space are neighbours in memory. A search in a large mesh then reads few cache
// lines.
#pragma once

#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh {

/// Returns the mesh with its triangles sorted along a Z-order curve (Morton 1966) through their centroids. The vertices
/// keep their indices. Equal meshes give equal orders. Not for the servo thread; allocates memory.
TissueMesh in_spatial_order(TissueMesh mesh);

}  // namespace typodont::haptics::mesh
