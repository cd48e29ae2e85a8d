// Converts the triangles of a brick (a block of the tissue's mesh) to the renderer's format.
#pragma once

#include <cstdint>

#include "engine/render/renderer.h"
#include "engine/surface/surface_mesher.h"

namespace typodont {

/// Returns a unique number for each brick (mesh block). `key`: index of the brick along each axis.
std::uint64_t brick_number(const glm::ivec3& key);

/// Converts a brick (mesh block) to the renderer's format, with positions in m from the volume's origin. `voxel`: voxel
/// size, m.
render::MeshUpdate brick_update(const surface::BrickMesh& mesh, double voxel);

}  // namespace typodont
