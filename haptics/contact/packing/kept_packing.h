// Packings kept between runs: making one takes seconds. Set-up time.
#pragma once

#include "haptics/sphere_packer.h"

namespace typodont::haptics::packing {

/// pack_spheres(), or what it gave for the same tissue and options before. Equal input, equal bits.
SpherePacking kept_packing(const TissueVolume& tissue, const PackOptions& options);

}  // namespace typodont::haptics::packing
