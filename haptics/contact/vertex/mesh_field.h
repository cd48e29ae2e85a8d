// Computes the distance field of a mesh in the regions that cuts have changed. Carver thread only.
#pragma once

#include "haptics/contact/vertex/vertex_body.h"

namespace typodont::haptics::vertex {

/// Computes the distance field in `blocks`. If a cut has moved the face nearest to a sample, the value of the sample is
/// the distance to this face; otherwise the original value is kept. Samples far from all faces get the sign of their
/// neighbours.
std::vector<RasterBlock> field_of(const mesh::EditableMesh& mesh, const FieldBlocks& blocks,
                                  const TissueVolume& untouched, const TissueVolume& now);

}  // namespace typodont::haptics::vertex
