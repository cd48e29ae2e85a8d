// The field where cuts changed the mesh. Carver thread.
#pragma once

#include "haptics/contact/vertex/vertex_body.h"

namespace typodont::haptics::vertex {

/// In `blocks`: near a face moved by a cut, the distance to it, but not below that before all cuts; otherwise the old
/// value. Far from all, inside before and outside now: positive.
std::vector<RasterBlock> field_of(const mesh::EditableMesh& mesh, const FieldBlocks& blocks,
                                  const TissueVolume& untouched, const TissueVolume& now);

}  // namespace typodont::haptics::vertex
