// The distance field of a mesh that was cut, where it was cut. Carver thread.
#pragma once

#include "haptics/contact/vertex/vertex_body.h"

namespace typodont::haptics::vertex {

/// Where the nearest face is one that a cut has moved, the field is the distance to it, and where none was, the
/// tissue's own. Samples far from all faces have the sign of those around them.
std::vector<RasterBlock> field_of(const mesh::EditableMesh& mesh, const FieldBlocks& blocks,
                                  const TissueVolume& untouched, const TissueVolume& now);

}  // namespace typodont::haptics::vertex
