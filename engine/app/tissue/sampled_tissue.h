// Samples a scene's solids or mesh on voxels. If that takes long (as for the distances of a mesh), the result is cached
// between runs, under a key made of the JSON text, the meshes' bytes and this program.
#pragma once

#include "engine/base/json.h"
#include "haptics/solid.h"

namespace typodont {

/// Same bits as haptics::read_solids(), or haptics::rasterize() for a tissue {"mesh": …}, cached or not. `files.find`
/// must be set. Throws Error.
haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files);

}  // namespace typodont
