// Corrects borders of thin tissues, where thresholds fail because of blur and mixed voxels.
#pragma once

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Moves the zero set of `field` near each sample of `border`: the sum of `fraction` over a ball gives the number of
/// its samples that belong to the tissue, and the field is lowered by the value that so many samples exceed. Blur
/// changes single fractions, but not their sum. Only samples in `body` count. `blur`: voxels.
void match_volume(Sparse<float>& field, const Sparse<float>& fraction, const SparseMask& border, const SparseMask& body,
                  double blur);

}  // namespace typodont::haptics::importing
