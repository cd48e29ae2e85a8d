// Corrects the borders of enamel and pulp in a tooth.
#pragma once

#include <optional>

#include "haptics/import/levels.h"
#include "haptics/import/local_grey.h"
#include "haptics/import/segment.h"

namespace typodont::haptics::importing {

/// voxels, smallest blur of a scan; the mean over a voxel alone is a blur of 0.3 voxels
inline constexpr double kLeastBlur = 0.4;

/// Moves the borders of enamel and pulp in a tooth until their volumes agree with the grey values (partial_volume.h).
/// `enamel_grey` has no value if the grey value of enamel is unknown. `pulp_grey` is used if no pulp is wide enough to
/// measure its grey value.
void match_tooth_volumes(const Grid<float>& grey, Segmentation& s, const SparseMask& enamel, const SparseMask& pulp,
                         const Levels& levels, const std::optional<LocalGrey>& enamel_grey, double pulp_grey,
                         const LocalGrey& outside);

}  // namespace typodont::haptics::importing
