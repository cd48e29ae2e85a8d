// Packings in a cache on disk, because a packing takes seconds to compute. Set-up only.
#pragma once

#include "haptics/packing.h"

namespace typodont::haptics::packing {

/// Result of pack_spheres(), read from the cache if it is stored there. Equal input gives equal bits.
SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options);

}  // namespace typodont::haptics::packing
