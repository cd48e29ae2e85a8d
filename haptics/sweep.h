// What a head sweeps in a tick. Servo and carver cut with it, so copy and tissue stay equal to the bit.
#pragma once

#include <cstdint>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/removed.h"
#include "haptics/cutting/way.h"
#include "haptics/tool.h"

namespace typodont::haptics {

class CutFront;

/// From pose A to B: an exact capsule for a ball; otherwise largest depth on the path within 5e-4 voxels. An implant
/// drill along its axis cuts with its end only.
class Sweep {
 public:
  /// `continues`: the last sweep ended at A and cut there; only tissue ahead can change.
  Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame, bool continues = false);

  /// Inclusive; voxels within `kMargin` of the swept head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Voxels lo to lo+size-1: larger of the old distance and the depth in the swept head (up to kInner). z fastest,
  /// strides in samples. `removed` (may be null): volume per tissue, needs `tissue`. True: changed. Any thread; same
  /// bits on every processor.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, RemovedVolume* removed) const noexcept;

  /// From a patch of n³ samples at `patch_lo`; `front` chooses samples.
  bool carve(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
             RemovedVolume* removed) const noexcept;

  static constexpr int kLeaf = 8;
  /// 8³ samples. `due`: per block of 4 × 4 × 8, the farthest point's path (voxels) at which it must be examined.
  /// `emptied`: a sample may have become air.
  struct Leaf {
    static constexpr int kBlocks = 4;
    glm::ivec3 lo;
    float* distance;
    float* due;
    bool changed = false, emptied = false;
  };
  /// `path`: so far.
  void carve(std::span<Leaf> leaves, float path) const noexcept;

  /// In a leaf. `slack`: voxels that the farthest point may move before a sample can change.
  struct LeafCut {
    bool changed = false, emptied = false;
    float slack = 0;
  };

  /// Depths are computed along the whole path, not only its end: slower.
  bool is_long() const noexcept { return straights_ > 0; }

  /// Returns true if both sweeps have the same head.
  bool same_head(const Sweep& other) const noexcept;
  /// Returns an upper bound of the path length of the head's farthest point, from the end of `before` to the end of
  /// this sweep, in voxels.
  double path_from(const Sweep& before) const noexcept;

  /// voxels; a cut computes correct distances up to this distance from the new surface, because the cubic interpolation
  /// reads samples up to there
  static constexpr float kMargin = 3.5f;
  /// voxels, largest depth that a cut writes. Samples that lie deeper inside the head do not need their exact depth.
  static constexpr float kInner = 3.0f;

 private:
  bool carve_ball(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept;
  /// Removes tissue from a block of samples, for a head that is not a ball.
  bool carve_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept;
  LeafCut carve_leaf_ball(const glm::ivec3& lo, float* distance) const noexcept;
  /// Does the same as carve() for a long path of a head that is not a ball.
  LeafCut carve_leaf_way(const glm::ivec3& lo, float* distance) const noexcept;
  /// Does the same as carve() for a short path of a head that is not a ball.
  void carve_head_leaves(std::span<Leaf> leaves, float path) const noexcept;
  bool carve_ball(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  RemovedVolume* removed) const noexcept;
  bool carve_head(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  RemovedVolume* removed) const noexcept;
  /// Removes tissue as carve() does, but along a long path. `known` (may be null): blocks of samples that need not be
  /// examined yet are skipped, because none of their samples can change.
  bool carve_way(const HeadTarget& target, RemovedVolume* removed, const DueBlocks* known) const noexcept;
  /// Removes tissue from the blocks of samples in one part of the active front (CutFront), for a head that is not a
  /// ball. `listed`: number of groups (8 or 16 samples along z) that were added to the list.
  bool carve_due_head(CutFront& front, int part, float ahead, PathMaxima& tops, const glm::ivec3& patch_lo, int n,
                      float* distance, const Tissue* tissue, int& listed) const noexcept;
  /// Removes tissue without lists of groups: examines each due block in some parts of the active front (CutFront).
  /// `parts`: these parts, one bit for each.
  bool carve_due_blocks(CutFront& front, unsigned parts, PathMaxima& tops, const HeadTarget& target) const noexcept;
  /// Returns true if this patch (copied tissue) contains all samples that were listed around the head in another patch.
  bool holds_listed(const glm::ivec3& patch_lo, int n) const noexcept;
  Straight way_back() const noexcept {
    Straight way = back_;
    way.pieces = pieces_;
    return way;
  }
  /// Returns an upper bound (voxels) of the rounding error of a sample's depth in a head that is not a ball.
  float rounding_of_depth() const noexcept { return 1e-3f + 2e-6f * static_cast<float>(reach_); }
  /// Returns true if the step is so short that the ball at the end of the sweep (B) can replace the capsule from A to
  /// B. The surfaces of both differ by |AB|² / (8 · radius).
  bool is_ball() const noexcept { return continues_ && glm::dot(ab_, ab_) < 8e-5f * radius_; }

  bool sphere_, continues_;
  // true: the drill continues along its axis and cuts only with its end, so samples beside its flank do not change.
  bool along_axis_ = false;
  MeridianPiece pieces_[HeadField::kMaxPieces];  // meridian of a head that is not a ball, voxels
  // straight path of the head from pose B back to pose A; read it with way_back(), which sets its member `pieces`
  Straight back_;
  // voxels; positions are stored relative to this point, so that floats are precise; it lies near both ends A and B of
  // the sweep
  glm::ivec3 base_;
  glm::vec3 a_, ab_;       // voxels; a_: position A relative to base_; ab_: vector from A to B (the capsule's axis)
  float inverse_length2_;  // 1/|ab|²; 0 if A and B are equal
  float radius_;           // voxels, largest radius of the head
  // Number of segments into which a long path is divided. In each segment, a sample moves through the head on a
  // straight line. Not used for balls.
  int straights_ = 0;
  // true if the paths of samples get a second-order term (Straight::bend_turn), so that the path has fewer segments
  bool bends_ = false;
  double turn_ = 0;  // rad, rotation of the head from A to B
  double reach_;     // voxels, distance from the head's centre to its farthest point
  // Voxels, half the length of the axis of a head that is not a ball. The head lies within radius_ of the axis.
  double half_length_;
  double travel_;     // voxels, path length of the head's farthest point; for a ball, of its centre
  Pose X_VA_, X_VB_;  // poses A and B of a head that is not a ball, in voxels of the volume
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
