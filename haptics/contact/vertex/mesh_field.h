// Updates the distance field after cuts. Carver thread only.
#pragma once

#include "haptics/contact/vertex/vertex_body.h"

namespace typodont::haptics::vertex {

/// Computes the distance field in `blocks`. Near a face that a cut has moved, a value is the distance to the face, but
/// not less than before all cuts. Elsewhere: the old value, or a positive constant where tissue was removed.
std::vector<RasterBlock> field_of(const mesh::EditableMesh& mesh, const FieldBlocks& blocks,
                                  const TissueVolume& untouched, const TissueVolume& now);

}  // namespace typodont::haptics::vertex
