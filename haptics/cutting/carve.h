// Cuts and fillings in a patch. The carver's volume repeats them with the same kernels, so both hold the same bits.
#pragma once

#include "haptics/fill.h"
#include "haptics/surface_patch.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

class CutFront;
class VoxelStamp;

/// Removes the swept head from the patch, and takes the label of a filling off the voxels that it lays bare. Returns
/// the removed volume per tissue in voxels³ (fraction of each voxel inside the surface before, less after). `changed`,
/// where given, tells whether any sample changed, be it only a distance in the air. `front`, where given, is what is
/// known of this patch and tool. `hardened`, where given, is the removed volume with every voxel's fraction times its
/// hardness: what the cut costs.
PerTissue carve(SurfacePatch& patch, const Sweep& sweep, bool* changed = nullptr, CutFront* front = nullptr,
                PerTissue* hardened = nullptr) noexcept;
/// The same with whole voxels.
PerTissue carve(SurfacePatch& patch, const VoxelStamp& stamp, bool* changed = nullptr,
                PerTissue* hardened = nullptr) noexcept;

/// Puts the filling into the patch. Returns the added volume per tissue in voxels³.
PerTissue fill(SurfacePatch& patch, const Fill& filling, bool* changed) noexcept;

/// Takes over from `old`, a patch of the same size, all that was cut in the inclusive box of voxels: the larger of both
/// distances holds. With `filled`, the box was also filled: then all samples of `old` hold, labels included.
void merge(SurfacePatch& patch, const SurfacePatch& old, const glm::ivec3& lo, const glm::ivec3& hi,
           bool filled = false) noexcept;

}  // namespace typodont::haptics
