// Corrects the borders of thin tissues. Blur and voxels that contain two tissues (partial volume) change the grey
// values in a thin layer or canal, so that no fixed threshold finds its border.
#pragma once

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Moves the border of a tissue until the labels agree with the volume that the grey values state. `field` is positive
/// in the tissue. `fraction` states which fraction of each voxel is this tissue. Blur can make a single fraction wrong,
/// but it does not change the sum of the fractions across a layer or a canal. For each sample of `border`, the function
/// therefore computes the sum of the fractions in a ball around the sample. From the field at the sample, it subtracts
/// the value that is exceeded by as many samples of the ball as this sum. Only samples in `body` can be in the tissue.
/// `blur`: voxels, standard deviation of the scan's blur.
void match_volume(Sparse<float>& field, const Sparse<float>& fraction, const SparseMask& border, const SparseMask& body,
                  double blur);

}  // namespace typodont::haptics::importing
