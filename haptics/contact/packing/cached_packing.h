// Stores sphere packings on disk and reuses them in later runs, because the computation of a packing takes seconds.
// Called only during set-up, not by the servo thread.
#pragma once

#include "haptics/sphere_packer.h"

namespace typodont::haptics::packing {

/// Returns the result of pack_spheres(). If the cache contains the packing of the same tissue with the same options,
/// reads it from there. Equal input gives equal bits.
SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options);

}  // namespace typodont::haptics::packing
