// Caches packings between runs, because making one takes seconds. Set-up time.
#pragma once

#include "haptics/sphere_packer.h"

namespace typodont::haptics::packing {

/// Returns the same result as pack_spheres(). If an earlier call with the same tissue and options stored it, reads it
/// from the cache. Equal input gives equal bits.
SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options);

}  // namespace typodont::haptics::packing
