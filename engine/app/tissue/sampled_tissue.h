// A scene's solids or mesh on a voxel grid, cached between runs if slow. The key covers the JSON, the meshes' bytes and
// the program's sources.
#pragma once

#include "engine/base/json.h"
#include "haptics/solid.h"

namespace typodont {

/// The same bits as haptics::read_solids() or haptics::rasterize(). Needs `files.find`. Throws Error.
haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files);

}  // namespace typodont
