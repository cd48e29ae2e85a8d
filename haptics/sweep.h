// The volume that a head sweeps in one tick. Servo and carver cut with the same code, so the tissue patch and the
// tissue stay bit-identical.
#pragma once

#include <cstdint>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/path.h"
#include "haptics/cutting/removed.h"
#include "haptics/tool.h"

namespace typodont::haptics {

class CutFront;

/// Sweep from pose A to pose B: an exact capsule for a ball; for other heads the largest depth along the path, within
/// 5e-4 voxels. An implant drill that moves along its axis cuts only with its end.
class Sweep {
 public:
  /// `continues`: the last sweep ended at A and removed the tissue there, so only tissue ahead can change.
  Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame, bool continues = false);

  /// First and last voxel (inclusive) of the box within `kMargin` of the swept head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Cuts samples lo to lo+size-1 (z runs fastest; strides in samples): each distance becomes the larger one of itself
  /// and the depth in the swept head, up to kInner. `removed` (may be null): volume per tissue; it needs `tissue`.
  /// Returns true if a sample changed. Bit-identical on every processor. Any thread.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, RemovedVolume* removed) const noexcept;

  /// Cuts a tissue patch of n³ samples that starts at `patch_lo`; `front` selects the samples to examine.
  bool carve(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
             RemovedVolume* removed) const noexcept;

  static constexpr int kLeaf = 8;
  /// A leaf of 8³ samples. `due`: for each block of 4 × 4 × 8 samples, the path length (voxels) at which it must be
  /// examined again. `emptied`: a sample may have become air.
  struct Leaf {
    static constexpr int kBlocks = 4;
    glm::ivec3 lo;
    float* distance;
    float* due;
    bool changed = false, emptied = false;
  };
  /// Cuts the leaves. `path`: path length of the head so far, voxels.
  void carve(std::span<Leaf> leaves, float path) const noexcept;

  /// Result for one leaf. `safe_travel`: path length that the head may still move before a sample can change, voxels.
  struct LeafCut {
    bool changed = false, emptied = false;
    float safe_travel = 0;
  };

  /// Returns true for a long path: depths are computed along the whole path (slower), not only at its end pose.
  bool is_long() const noexcept { return straights_ > 0; }

  /// Returns true if both sweeps have the same head.
  bool same_head(const Sweep& other) const noexcept;
  /// Returns an upper bound of the path length of the head's farthest point, from the end of `before` to the end of
  /// this sweep, in voxels.
  double path_from(const Sweep& before) const noexcept;

  /// A cut writes correct distances to samples that are up to this far from the new surface, voxels, because cubic
  /// interpolation reads them.
  static constexpr float kMargin = 3.5f;
  /// Limit of the depths that a cut writes, voxels. Deeper inside the head, samples do not need their exact depth.
  static constexpr float kInner = 3.0f;

 private:
  bool carve_ball(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept;
  /// Removes tissue from a block of samples, for a head that is not a ball.
  bool carve_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept;
  LeafCut carve_leaf_ball(const glm::ivec3& lo, float* distance) const noexcept;
  /// Cuts one leaf along a long path, for a head that is not a ball.
  LeafCut carve_leaf_path(const glm::ivec3& lo, float* distance) const noexcept;
  /// Cuts leaves along a short path, for a head that is not a ball.
  void carve_head_leaves(std::span<Leaf> leaves, float path) const noexcept;
  bool carve_ball(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  RemovedVolume* removed) const noexcept;
  bool carve_head(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                  RemovedVolume* removed) const noexcept;
  /// Cuts along a long path, for a head that is not a ball. `known` (may be null): path lengths at which blocks must be
  /// examined; before them, blocks are skipped.
  bool carve_path(const HeadTarget& target, RemovedVolume* removed, const DueBlocks* known) const noexcept;
  /// Cuts the blocks of one part of `front` (samples that may be cut next), for a head that is not a ball. `listed`:
  /// number of groups (8 or 16 samples along z) that were added to the list.
  bool carve_due_head(CutFront& front, int part, float ahead, PathMaxima& tops, const glm::ivec3& patch_lo, int n,
                      float* distance, const Tissue* tissue, int& listed) const noexcept;
  /// Cuts without lists of groups: in the selected parts of `front` (samples that may be cut next), examines the blocks
  /// that must be examined now. `parts`: one bit for each part.
  bool carve_due_blocks(CutFront& front, unsigned parts, PathMaxima& tops, const HeadTarget& target) const noexcept;
  /// Returns true if the new tissue patch contains all listed samples. The lists were made with another patch.
  bool holds_listed(const glm::ivec3& patch_lo, int n) const noexcept;
  Straight path_back() const noexcept {
    Straight straight = back_;
    straight.pieces = pieces_;
    return straight;
  }
  /// Returns an upper bound of the rounding error of a sample's depth, voxels, for a head that is not a ball.
  float rounding_of_depth() const noexcept { return 1e-3f + 2e-6f * static_cast<float>(reach_); }
  /// Returns true if the path AB is so short that the ball at B can replace the capsule from A to B. The surfaces of
  /// ball and capsule differ by |AB|² / (8 · radius).
  bool is_ball() const noexcept { return continues_ && glm::dot(ab_, ab_) < 8e-5f * radius_; }

  bool sphere_, continues_;
  // true: the drill continues along its axis and cuts only with its end; samples beside its flank do not change.
  bool along_axis_ = false;
  MeridianPiece pieces_[HeadField::kMaxPieces];  // meridian of a head that is not a ball, voxels
  // Straight path of the head from pose B back to pose A. Read it with path_back(), which first sets back_.pieces.
  Straight back_;
  // Voxel near the poses A and B; positions are stored relative to it, so that floats are precise.
  glm::ivec3 base_;
  glm::vec3 a_, ab_;       // voxels; a_: position at A relative to base_; ab_: vector from A to B (axis of the capsule)
  float inverse_length2_;  // 1/|ab|²; 0 if A and B are equal
  float radius_;           // voxels, largest radius of the head
  // Number of segments of a long path; in each segment, samples move on straight lines relative to the head. 0: short
  // path, or ball.
  int straights_ = 0;
  // true: sample paths get a second-order term (Straight::bend_turn), so that fewer segments suffice.
  bool bends_ = false;
  double turn_ = 0;  // rad, rotation of the head from A to B
  double reach_;     // voxels, distance from the head's centre to its farthest point
  // Half the length of the axis of a head that is not a ball, voxels. The head lies within radius_ of the axis.
  double half_length_;
  double travel_;     // voxels, length of the path of the head's farthest point (ball: of its centre) from A to B
  Pose X_VA_, X_VB_;  // poses A and B of a head that is not a ball, in voxels of the volume
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
