// A short motion as seen from the head: samples move on lines, and their depth is a concave function of time. Private
// to haptics/cutting.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"
#include "haptics/cutting/removed.h"

namespace typodont::haptics {

/// Motion from one pose to another, seen in frame T: a sample moves from p to p + shift + turn p, voxels.
struct Straight {
  HeadPose from;
  float shift[3], turn[9];  // turn: column by column; shift: voxels
  const MeridianPiece* pieces;
  int count;
  float turned;   // voxels, largest difference of the motions of two samples that are one voxel apart
  float longest;  // voxels, longest motion, relative to the head, of a sample that is near enough to be cut
  float slip;     // voxels, error of a tangent to a sample's depth over time
  // For a motion along a cylinder's axis: a sample does not change if z > still_above and rho + z > still_beyond (frame
  // T; rho: distance from the axis), because it stays above the rim and nearest to the flank. Otherwise kNoEnd.
  float still_above = kNoEnd, still_beyond = kNoEnd;
  // Second-order term: at fraction s of the path, sample p is off its line by s (s - 1) (bend_shift + bend_turn p).
  float bend_shift[3] = {}, bend_turn[9] = {};
  // voxels, largest distance of a sample's curved path from the straight line; 0 without second-order term
  float bent = 0;
};
Straight straight_path(const Pose& X_VA, const Pose& X_VB, const MeridianPiece* pieces, int count, double reach);

/// Sets the second-order term for a path from pose A. `X_VM`: pose in the middle of the path.
void bend(Straight& path, const Pose& X_VA, const Pose& X_VM, double reach);
/// Returns true if a round end continues the flank (piece `i` of the meridian) at its lower end.
bool has_round_end(const MeridianPiece* pieces, int i);

/// Path lengths at which blocks of 4 × 4 × 8 voxels must be examined (CutFront); z is the fastest index. A sweep does
/// not change the path length of a block for which it computes no result.
struct DueBlocks {
  float* due;
  glm::ivec3 first, size;  // index of the first block; number of blocks along each axis
  float path_length;       // voxels, path length at the end of the sweep
  float slip;              // voxels, largest rounding error of a depth

  /// Path lengths of the blocks along z from the one at `voxel` to the one at `last_z`; null: some are not stored.
  float* row(const glm::ivec3& voxel, int last_z) const noexcept;
};

inline constexpr float kTop = 5e-4f;  // voxels, allowed error of the largest depth on a path
// voxels; for shorter motions only the final pose is used, which takes a seventh less time
inline constexpr float kSlow = 0.05f;
// voxels; nearer than this to a corner of the meridian, rounding errors dominate the normal
inline constexpr float kNear = 0.01f;

/// Distance r from the axis beyond which no search is needed: over a motion of length L below one piece, a sample is at
/// most L² / (4 r) deeper than at the ends, which is below kTop.
inline float smooth_from(const Straight& path, const MeridianPiece& piece) {
  const float least = path.longest * path.longest / (3.6f * kTop);
  // 4: samples are at most kInner (3 voxels) below an arc, so at least 1 voxel more than `least` from its centre.
  return piece.radius == 0.0f || piece.radius > least + 4 ? least : kNoEnd;
}

/// List of samples that may have been deeper earlier in the motion than at its end, where they have been cut.
struct PathMaxima {
  static constexpr int kCapacity = 1024;

  Straight back;  // motion from the end pose back to the start pose
  RemovedVolume* removed;
  bool changed = false;
  int count = 0;
  // voxels, positions of the listed samples relative to HeadPose::base of the last pose
  float x[kCapacity], y[kCapacity], z[kCapacity];
  float* at[kCapacity];
  std::uint8_t label[kCapacity];

  PathMaxima(const Straight& path_back, RemovedVolume* taken) : back(path_back), removed(taken) {}
  /// Call it before `samples` samples are added. If the list would be full, cuts its samples and empties it.
  void make_room(int samples) noexcept {
    if (count > kCapacity - samples) carve();
  }
  void add(float at_x, float at_y, float at_z, float* sample, std::uint8_t tissue) noexcept {
    x[count] = at_x, y[count] = at_y, z[count] = at_z, at[count] = sample, label[count++] = tissue;
  }
  /// Cuts the listed samples and empties the list.
  void carve() noexcept;
};

}  // namespace typodont::haptics
