// Samples a scene's solids or mesh on voxels. If this takes long (for example the distances of a mesh), the result is
// cached between runs. The cache's key depends on the JSON text, the bytes of the meshes and this program.
#pragma once

#include "engine/base/json.h"
#include "haptics/solid.h"

namespace typodont {

/// Samples the tissue. The result has the same bits as that of haptics::read_solids(), or of haptics::rasterize() for
/// a tissue {"mesh": …}, with and without the cache. `files.find` must be set. Throws Error.
haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files);

}  // namespace typodont
