// Cuts and fillings in a tissue patch. This file is the main header of the folder haptics/cutting.
//
// Overview of the folder. Tissue is stored as a distance field. Each voxel of a grid stores one sample. A sample is the
// signed distance from the voxel to the nearest surface, in voxels, negative inside the tissue. Each voxel also stores
// a label, which names its tissue. A tissue patch is a dense copy of the distance field around the tool. The head of a
// tool is its cutting end.
//
// A sweep is the volume that the head passes through in one tick of the servo. The depth of a voxel in the sweep is its
// largest depth inside the head during the motion. A cut raises every sample that is smaller than the depth of its
// voxel to this depth. After the cut, the surface of the field coincides with the surface of the head. The cut also
// sums the removed volume of each tissue.
//
// The servo thread cuts its tissue patch with the functions of this file. The carver thread owns the whole volume, and
// repeats every cut in it. Both threads use the same kernels, so that patch and volume contain bit-identical samples. A
// kernel is a function that processes 8 or 16 samples with one vector instruction (lane_ops.h).
//
// To save time, the servo does not examine every sample around the head. The active front (haptics/cutting/cut_front.h)
// stores how far the head must still move before a sample can change. The kernels therefore examine only the samples
// that can change in this tick.
//
// Files in reading order:
// - haptics/sweep.h: the class Sweep, which ball.cpp and head.cpp implement for balls and for all other heads.
// - meridian.h: the outline of a head that is not a ball, as lines and arcs. depth_kernel.h: depth of samples in such a
//   head.
// - path.h and path_kernel.h: the largest depth of a sample while a head that is not a ball moves.
// - cut_kernel.h and removed.h: the change of the samples, and the sum of the removed volume.
// - listed.h and listed_kernel.h: cuts of the groups of samples in the lists of the active front. A group is 8 or 16
//   consecutive samples along z.
// - leaf.cpp: cuts in one leaf (8³ samples) of the carver's volume.
// - fill_kernel.cpp and placed_head.h: the opposite of a cut; a filling or an implant is added.
// - voxel_stamp.h: removal of whole voxels, as a reference for comparison.
//
// docs/cutting.md explains the methods and the measurements. docs/glossary.md defines the terms.
#pragma once

#include "haptics/contact/tissue_patch.h"
#include "haptics/fill.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

class CutFront;
class VoxelStamp;

/// Cuts in the servo's tissue patch. Returns the removed volume of each tissue in voxels³. Removed filling loses its
/// label. `changed`: true if a sample changed, even in air. `front`: samples that this tool may cut next. `hardened`:
/// removed volume × hardness.
PerTissue carve(TissuePatch& patch, const Sweep& sweep, bool* changed = nullptr, CutFront* front = nullptr,
                PerTissue* hardened = nullptr) noexcept;
/// Like carve() above, but removes the whole voxels of `stamp`.
PerTissue carve(TissuePatch& patch, const VoxelStamp& stamp, bool* changed = nullptr,
                PerTissue* hardened = nullptr) noexcept;

/// Adds filling to the servo's tissue patch. Returns the added volume of each tissue in voxels³.
PerTissue fill(TissuePatch& patch, const Fill& filling, bool* changed) noexcept;

/// Adds the cuts that were made in `old` while `patch` was copied: in the box lo..hi (inclusive), each sample becomes
/// the larger of its values in `patch` and `old`. `filled` true: copies all samples and labels of the box from `old`.
void merge(TissuePatch& patch, const TissuePatch& old, const glm::ivec3& lo, const glm::ivec3& hi,
           bool filled = false) noexcept;
/// Updates the boxes of changed samples in `patch` as merge() does, without changing samples.
void mark_merged(TissuePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi, bool filled) noexcept;

}  // namespace typodont::haptics
