// The space a head sweeps in one tick, as a distance on voxels. The servo's patch and the carver's volume both cut with
// exactly this function, so that they hold the same bits.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "haptics/cutting/way.h"
#include "haptics/tool.h"

namespace typodont::haptics {

class CutFront;

/// The space that a head sweeps from A to B: of a sphere the exact capsule, of other heads the greatest depth of each
/// voxel on the way, within 5e-4 voxels.
class Sweep {
 public:
  /// `continues`: the head at A was cut out before, by the sweep that ended there, so only what lies ahead need change.
  /// `laws`: version of the servo's laws. Versions differ in the last bits.
  Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame, bool continues = false,
        std::uint32_t laws = kServoLaws);

  /// Voxels, inclusive, that lie within `kMargin` voxels of the swept head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Raises the distances of a block of voxels, lo .. lo+size-1, to how deep each lies in the swept head (at most
  /// kInner), wherever that is more: takes material away. z runs fastest; the strides are in samples. Adds to
  /// `removed`, where given, the volume taken per tissue in voxels³ (the share of each voxel inside the surface before,
  /// less after). Returns whether any sample changed. Any thread; the same bits whatever the processor.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, PerTissue* removed) const noexcept;

  /// The same in a whole patch of n³ samples from voxel `patch_lo` on; `front` knows what can change in it.
  bool carve(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
             PerTissue* removed) const noexcept;

  /// The same in one leaf: 8³ samples from voxel `lo` on, side by side. `slack`: voxels that the head's farthest point
  /// may go on, whichever way, before any sample of the leaf can change. `emptied`: a sample may have turned to air.
  struct LeafCut {
    bool changed = false, emptied = false;
    float slack = 0;
  };
  LeafCut carve_leaf(const glm::ivec3& lo, float* distance) const noexcept;
  static constexpr int kLeaf = 8;

  /// Whether the other sweep is one of the same head.
  bool same_head(const Sweep& other) const noexcept;
  /// Voxels that the head's farthest point goes from the end of `before` to the end of this sweep, at most.
  double path_from(const Sweep& before) const noexcept;

  /// Distances are kept true as far as this from the new surface: the reach of the cubic interpolation.
  static constexpr float kMargin = 3.5f;
  /// Deeper inside the head all is equally empty: only the shell that matters is written, not the ball.
  static constexpr float kInner = 3.0f;

 private:
  bool carve_ball(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept;
  /// `leaf`, where the box is one: what else is found of it.
  bool carve_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, PerTissue* removed,
                  LeafCut* leaf = nullptr) const noexcept;
  LeafCut carve_leaf_ball(const glm::ivec3& lo, float* distance) const noexcept;
  bool carve_ball(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  PerTissue* removed) const noexcept;
  bool carve_head(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  PerTissue* removed) const noexcept;
  /// Of a long way. Blocks that are not yet due by `known`, which may be null, are left out: no sample of them changes.
  bool carve_way(const HeadTarget& target, PerTissue* removed, const DueBlocks* known) const noexcept;
  /// One part of the front of a head that is no ball; `listed`: groups found.
  bool carve_due_head(CutFront& front, int part, float ahead, Tops& tops, const glm::ivec3& patch_lo, int n,
                      float* distance, const Tissue* tissue, int& listed) const noexcept;
  /// Whether what was listed around the head in another patch lies within this one.
  bool holds_listed(const glm::ivec3& patch_lo, int n) const noexcept;
  Straight way_back() const noexcept {
    Straight way = back_;
    way.pieces = pieces_;
    return way;
  }
  /// Largest rounding error of a sample's depth in a head that is no ball, voxels.
  float rounding_of_depth() const noexcept { return 1e-3f + 2e-6f * static_cast<float>(reach_); }
  /// True of a step so short that the ball at B stands for the capsule: they differ by ab²/8r.
  bool is_ball() const noexcept { return continues_ && glm::dot(ab_, ab_) < 8e-5f * radius_; }

  bool sphere_, continues_;
  std::uint32_t laws_;
  MeridianPiece pieces_[HeadField::kMaxPieces];  // of other heads, in voxels …
  Straight back_;                                // … with the way from B back to A, but for what it points to
  glm::ivec3 base_;                              // coordinates are taken from here, so that floats keep their digits
  glm::vec3 a_, ab_;                             // capsule, in voxels from base_
  float inverse_length2_;                        // 1/|ab|², 0 for a point
  float radius_;                                 // voxels
  int straights_ = 0;   // of a long way of another head: parts on which samples go straight through it
  double turn_ = 0;     // of that, rad
  double reach_;        // voxels
  double half_length_;  // voxels, of heads that are no balls: they lie within radius_ of so much of their axis
  double travel_;       // voxels, of the head's farthest point; of a ball its centre
  Pose X_VA_, X_VB_;    // general heads: poses in voxels, absolute
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
