// Samples a scene's solids or mesh on voxels. If this takes long (for example the distances of a mesh), the result is
// cached between runs. The key of the cache depends on the JSON text, the meshes' bytes and this program.
#pragma once

#include "engine/base/json.h"
#include "haptics/solid.h"

namespace typodont {

/// Gives the same bits as haptics::read_solids(), or as haptics::rasterize() for a tissue {"mesh": …}, with and without
/// the cache. `files.find` must be set. Throws Error.
haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files);

}  // namespace typodont
