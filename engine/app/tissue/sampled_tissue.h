// Samples a scene's solids or mesh on a voxel grid. If this takes long (for example the distances of a mesh), the
// result is cached between runs of the program. The key in the cache depends on the JSON text, on the bytes of the
// meshes and on the program's sources.
#pragma once

#include "engine/base/json.h"
#include "haptics/solid.h"

namespace typodont {

/// Samples the tissue. With and without the cache, the result has the same bits as haptics::read_solids(), or as
/// haptics::rasterize() for a tissue {"mesh": …}. `files.find` must be set. Throws Error.
haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files);

}  // namespace typodont
