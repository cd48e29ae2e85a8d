// Cuts and fillings in a patch. The carver repeats the cuts and fillings in its volume with the same kernels, so that
// patch and volume contain the same bits.
#pragma once

#include "haptics/fill.h"
#include "haptics/surface_patch.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

class CutFront;
class VoxelStamp;

/// Removes the swept head from the patch, and removes the label of a filling from voxels that become air. Returns the
/// removed volume per tissue in voxels³ (for each voxel, the fraction inside the surface before the cut minus the
/// fraction after it). Optional results: `changed` becomes true if any sample changed, even if only a distance in air;
/// `hardened` is the removed volume weighted by each voxel's hardness, which determines the cost of the cut. `front` is
/// the active front of this patch and tool.
PerTissue carve(SurfacePatch& patch, const Sweep& sweep, bool* changed = nullptr, CutFront* front = nullptr,
                PerTissue* hardened = nullptr) noexcept;
/// Removes whole voxels; apart from this, the function is like carve() with a Sweep.
PerTissue carve(SurfacePatch& patch, const VoxelStamp& stamp, bool* changed = nullptr,
                PerTissue* hardened = nullptr) noexcept;

/// Adds the filling to the patch. Returns the added volume per tissue in voxels³.
PerTissue fill(SurfacePatch& patch, const Fill& filling, bool* changed) noexcept;

/// Transfers the cuts in the inclusive box lo..hi (voxels) from `old`, a patch of the same size, to `patch`: each
/// sample becomes the larger of its two distances. `filled`: true if the box was also filled; then all its samples are
/// copied from `old`, labels included.
void merge(SurfacePatch& patch, const SurfacePatch& old, const glm::ivec3& lo, const glm::ivec3& hi,
           bool filled = false) noexcept;

}  // namespace typodont::haptics
