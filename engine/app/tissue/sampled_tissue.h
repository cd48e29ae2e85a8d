// A scene's solids, or its mesh, on voxels. Where that takes long (a mesh's distances do), what was sampled is kept
// between runs, under a key made of the JSON text, the meshes' bytes and this program, so that the next start need not
// wait for it.
#pragma once

#include "engine/base/json.h"
#include "haptics/solid.h"

namespace typodont {

/// As haptics::read_solids(), or haptics::rasterize() of a tissue {"mesh": …}, bit for bit, kept or not. `files.find`
/// must be set. Throws Error.
haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files);

}  // namespace typodont
