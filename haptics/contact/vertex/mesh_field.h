// Computes the distance field of a mesh in the regions that cuts have changed. Carver thread only.
#pragma once

#include "haptics/contact/vertex/vertex_body.h"

namespace typodont::haptics::vertex {

/// Computes the distance field in `blocks`. If a sample is near the mesh, and a cut has moved the face nearest to it,
/// the new value is the signed distance to this face, but never less than the value before all cuts. Any other sample
/// keeps the value that it had before all cuts. Exception: a sample far from all faces that was inside the tissue, and
/// is now outside, gets a positive value.
std::vector<RasterBlock> field_of(const mesh::EditableMesh& mesh, const FieldBlocks& blocks,
                                  const TissueVolume& untouched, const TissueVolume& now);

}  // namespace typodont::haptics::vertex
