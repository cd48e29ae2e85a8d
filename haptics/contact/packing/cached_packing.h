// A cache on disk for packings (tissue as spheres), because a packing takes seconds to compute. Set-up only.
#pragma once

#include "haptics/packing.h"

namespace typodont::haptics::packing {

/// Result of pack_spheres(), read from the cache if it is stored there. Equal input gives bit-identical spheres.
SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options);

}  // namespace typodont::haptics::packing
