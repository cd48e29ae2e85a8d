// Corrects the borders of enamel and pulp in a tooth.
#pragma once

#include <optional>

#include "haptics/import/levels.h"
#include "haptics/import/local_grey.h"
#include "haptics/import/segment.h"

namespace typodont::haptics::importing {

/// voxels; the mean over a voxel alone is 0.3
inline constexpr double kLeastBlur = 0.4;

/// Until volumes agree with grey values (partial_volume.h). `enamel_grey`: empty if unknown; `pulp_grey`: for narrow
/// pulps.
void match_tooth_volumes(const Grid<float>& grey, Segmentation& s, const SparseMask& enamel, const SparseMask& pulp,
                         const Levels& levels, const std::optional<LocalGrey>& enamel_grey, double pulp_grey,
                         const LocalGrey& outside);

}  // namespace typodont::haptics::importing
