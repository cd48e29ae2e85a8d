// A brick's triangles as the renderer takes them.
#pragma once

#include "engine/render/renderer.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// Positions become metres from the volume's origin; `voxel`: m. nullptr: the brick has no surface any more.
render::MeshUpdate brick_update(const glm::ivec3& key, const surface::BrickMesh* mesh, double voxel);

}  // namespace typodont
