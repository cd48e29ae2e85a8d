// Computes the distance field of a mesh in the regions where it was cut. Carver thread.
#pragma once

#include "haptics/contact/vertex/vertex_body.h"

namespace typodont::haptics::vertex {

/// Computes the field in `blocks`. Where a cut moved the nearest face, the field is the distance to this face;
/// elsewhere it is the tissue's original field. Samples far from all faces get the sign of their neighbours.
std::vector<RasterBlock> field_of(const mesh::EditableMesh& mesh, const FieldBlocks& blocks,
                                  const TissueVolume& untouched, const TissueVolume& now);

}  // namespace typodont::haptics::vertex
