// Corrects borders of thin tissues, where thresholds fail because of blur and mixed voxels.
#pragma once

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Moves the zero set of `field` near the samples of `border`, so that a ball around each contains the right amount n
/// of tissue. n is the sum of `fraction` over the ball, which blur does not change. The value that n samples of the
/// ball exceed is subtracted from the field. Only samples in `body` count. `blur`: voxels.
void match_volume(Sparse<float>& field, const Sparse<float>& fraction, const SparseMask& border, const SparseMask& body,
                  double blur);

}  // namespace typodont::haptics::importing
