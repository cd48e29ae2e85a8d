// Corrects the borders of enamel and pulp in a tooth.
#pragma once

#include <optional>

#include "haptics/import/levels.h"
#include "haptics/import/local_grey.h"
#include "haptics/import/segment.h"

namespace typodont::haptics::importing {

/// Smallest blur of a scan, voxels; the averaging over a voxel alone gives 0.3.
inline constexpr double kMinBlur = 0.4;

/// Moves the borders of enamel and pulp until the tissues' volumes agree with the grey values (partial_volume.h).
/// `enamel_grey`: empty if unknown; `pulp_grey`: grey value for pulps that are too narrow to measure.
void match_tooth_volumes(const Grid<float>& grey, Segmentation& s, const SparseMask& enamel, const SparseMask& pulp,
                         const Levels& levels, const std::optional<LocalGrey>& enamel_grey, double pulp_grey,
                         const LocalGrey& outside);

}  // namespace typodont::haptics::importing
