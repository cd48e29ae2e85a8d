// Borders of thin tissues, where blur and mixed voxels defeat thresholds.
#pragma once

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Around each sample of `border`, the field is lowered by the value that as many samples of a ball exceed as their
/// `fraction`s sum to: blur changes fractions, not their sum. Only in `body`. `blur`: voxels.
void match_volume(Sparse<float>& field, const Sparse<float>& fraction, const SparseMask& border, const SparseMask& body,
                  double blur);

}  // namespace typodont::haptics::importing
