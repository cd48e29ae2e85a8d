// A brick's triangles as the renderer takes them.
#pragma once

#include <cstdint>

#include "engine/render/renderer.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// A number for each cell of a grid; two cells never share one.
std::uint64_t brick_number(const glm::ivec3& key);

/// Positions become metres from the volume's origin; `voxel`: m. nullptr: the brick has no surface any more.
render::MeshUpdate brick_update(const glm::ivec3& key, const surface::BrickMesh* mesh, double voxel);

}  // namespace typodont
