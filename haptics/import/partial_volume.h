// Corrects borders of thin tissues, where thresholds fail because of blur and mixed voxels.
#pragma once

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Moves the zero set of `field` near each sample of `border`: the sum of `fraction` over a ball is the number n of
/// samples that belong to the tissue. The field is lowered by the value that n samples of the ball exceed. Blur changes
/// the fraction of a single sample, but not the sum. Only samples in `body` count. `blur`: voxels.
void match_volume(Sparse<float>& field, const Sparse<float>& fraction, const SparseMask& border, const SparseMask& body,
                  double blur);

}  // namespace typodont::haptics::importing
