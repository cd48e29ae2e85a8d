// Converts a brick's triangles to the renderer's format.
#pragma once

#include <cstdint>

#include "engine/render/renderer.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// A unique number for each cell of a grid.
std::uint64_t brick_number(const glm::ivec3& key);

/// Converts a brick; positions become metres from the volume's origin. `voxel`: m. `mesh`: nullptr if the brick no
/// longer has a surface.
render::MeshUpdate brick_update(const glm::ivec3& key, const surface::BrickMesh* mesh, double voxel);

}  // namespace typodont
