// The volume that a head sweeps in one tick, as a distance field. The servo's patch and the carver's volume both cut
// with these functions, so they contain the same bits.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "haptics/cutting/removed.h"
#include "haptics/cutting/way.h"
#include "haptics/tool.h"

namespace typodont::haptics {

class CutFront;

/// The volume that a head sweeps from pose A to pose B. A cylindrical implant drill that continues along its axis cuts
/// only with its end. For a ball the volume is the exact capsule; for other heads,
/// each voxel gets its greatest depth on the path, within 5e-4 voxels.
class Sweep {
 public:
  /// `continues`: the previous sweep ended at A and removed the head's volume there, so only tissue ahead can change.
  /// `laws`: version of the servo's force laws (contact.h); the results of different versions differ slightly.
  Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame, bool continues = false,
        std::uint32_t laws = kServoLaws);

  /// Box of voxels, inclusive, that contains all voxels within `kMargin` voxels of the swept head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Raises the distances of a block of voxels, lo .. lo+size-1, to their depth in the swept head (at most kInner),
  /// wherever the depth is larger. This removes tissue. z runs fastest; the strides are in samples. `removed`, if
  /// given, receives the removed volume per tissue; then `tissue` must be given, too. Returns true if any sample
  /// changed. Any thread; the bits do not depend on the processor.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, RemovedVolume* removed) const noexcept;

  /// Carves a whole patch of n³ samples from voxel `patch_lo` on; `front` stores which samples can change.
  bool carve(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
             RemovedVolume* removed) const noexcept;

  /// Result of carving one leaf of 8³ samples. `slack`: voxels that the head's farthest point may move in any direction
  /// before a sample of the leaf can change. `emptied`: a sample may have become air.
  struct LeafCut {
    bool changed = false, emptied = false;
    float slack = 0;
  };
  LeafCut carve_leaf(const glm::ivec3& lo, float* distance) const noexcept;
  static constexpr int kLeaf = 8;

  /// True if both sweeps have the same head.
  bool same_head(const Sweep& other) const noexcept;
  /// Upper bound of the path length of the head's farthest point from the end of `before` to the end of this sweep,
  /// voxels.
  double path_from(const Sweep& before) const noexcept;

  /// voxels; distances are kept up to date up to this distance from the new surface, the range of the cubic
  /// interpolation
  static constexpr float kMargin = 3.5f;
  /// voxels, limit of the depths that are written: a sample deeper inside the head needs no exact depth.
  static constexpr float kInner = 3.0f;

 private:
  bool carve_ball(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept;
  /// `leaf`, if given: the box is a leaf, and *leaf receives `emptied` and `slack`.
  bool carve_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed,
                  LeafCut* leaf = nullptr) const noexcept;
  LeafCut carve_leaf_ball(const glm::ivec3& lo, float* distance) const noexcept;
  bool carve_ball(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  RemovedVolume* removed) const noexcept;
  bool carve_head(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  RemovedVolume* removed) const noexcept;
  /// Does the work of carve() for a long path. Leaves out the blocks that are not due yet according to `known` (may
  /// be null): none of their samples can change.
  bool carve_way(const HeadTarget& target, RemovedVolume* removed, const DueBlocks* known) const noexcept;
  /// One part of the front of a head that is not a ball; `listed`: number of groups found.
  bool carve_due_head(CutFront& front, int part, float ahead, PathMaxima& tops, const glm::ivec3& patch_lo, int n,
                      float* distance, const Tissue* tissue, int& listed) const noexcept;
  /// The due blocks of some parts (`parts`: one bit each) of the front, without lists.
  bool carve_due_blocks(CutFront& front, unsigned parts, PathMaxima& tops, const HeadTarget& target) const noexcept;
  /// True if this patch contains all samples that were listed around the head in another patch.
  bool holds_listed(const glm::ivec3& patch_lo, int n) const noexcept;
  Straight way_back() const noexcept {
    Straight way = back_;
    way.pieces = pieces_;
    return way;
  }
  /// Largest rounding error of a sample's depth in a head that is not a ball, voxels.
  float rounding_of_depth() const noexcept { return 1e-3f + 2e-6f * static_cast<float>(reach_); }
  /// True for a step so short that the ball at B replaces the capsule: they differ by ab²/8r.
  bool is_ball() const noexcept { return continues_ && glm::dot(ab_, ab_) < 8e-5f * radius_; }

  bool sphere_, continues_;
  // A drill that continues along its axis cuts only at its end; samples beside its flank do not change
  bool along_axis_ = false;
  std::uint32_t laws_;                           // version of the servo's force laws
  MeridianPiece pieces_[HeadField::kMaxPieces];  // meridian of a head that is not a ball, in voxels
  Straight back_;                                // path from pose B back to pose A; way_back() sets `pieces`
  glm::ivec3 base_;        // origin of the coordinates of A and B, so that floats keep their precision
  glm::vec3 a_, ab_;       // capsule: A and the vector from A to B, in voxels from base_
  float inverse_length2_;  // 1/|ab|², 0 for a point
  float radius_;           // voxels
  // Number of segments of a long path on which samples move straight through the head; not for balls
  int straights_ = 0;
  double turn_ = 0;  // rad, rotation of the head from A to B
  double reach_;     // voxels
  // voxels, half length of the axis, for heads that are not balls: the head lies within radius_ of the axis
  double half_length_;
  double travel_;     // voxels, path length of the head's farthest point; for a ball, of its centre
  Pose X_VA_, X_VB_;  // poses of heads that are not balls, in voxels of the volume
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
