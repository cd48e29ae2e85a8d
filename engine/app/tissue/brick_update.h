// Converts the triangles of a brick to the renderer's format.
#pragma once

#include <cstdint>

#include "engine/render/renderer.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// Each brick's unique number. `key`: its index along each axis.
std::uint64_t brick_number(const glm::ivec3& key);

/// Converts a mesh. Positions become m from the volume's origin.
render::MeshUpdate brick_update(const surface::BrickMesh& mesh, double voxel);

}  // namespace typodont
