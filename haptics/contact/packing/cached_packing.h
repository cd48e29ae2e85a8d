// A packing takes seconds, so later runs reuse it from disk. Set-up only.
#pragma once

#include "haptics/packing.h"

namespace typodont::haptics::packing {

/// pack_spheres(), or the same from the cache. Equal input, equal bits.
SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options);

}  // namespace typodont::haptics::packing
