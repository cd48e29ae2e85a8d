// Triangles of a brick in the renderer's format.
#pragma once

#include <cstdint>

#include "engine/render/renderer.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// Unique per brick. `key`: its index along each axis.
std::uint64_t brick_number(const glm::ivec3& key);

/// Positions in m from the volume's origin. `voxel`: m.
render::MeshUpdate brick_update(const surface::BrickMesh& mesh, double voxel);

}  // namespace typodont
