// Samples a scene's solids or mesh on a voxel grid, and caches the result between runs if it read a mesh or was slow.
// The cache key contains the JSON, the bytes of the meshes, and the program's sources.
#pragma once

#include "engine/base/json.h"
#include "haptics/solid.h"

namespace typodont {

/// Bit-identical to haptics::read_solids() or haptics::rasterize(), but cached. Needs `files.find`. Throws Error.
haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files);

}  // namespace typodont
