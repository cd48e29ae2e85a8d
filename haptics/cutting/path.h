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
  float turned;   // voxels, largest difference between the motions of two samples one voxel apart
  float longest;  // voxels, longest motion, relative to the head, of a sample that is near enough to be cut
  float slip;     // voxels, largest error of the tangent to the curve of a sample's depth along the path
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
/// Returns true if the flank (piece `i` of the meridian) is followed by a round end at its lower end.
bool has_round_end(const MeridianPiece* pieces, int i);

/// For each block of 4 × 4 × 8 voxels: path length of the head at which the block must be examined again (CutFront); z
/// is the fastest index. A sweep that computes no new value for a block keeps the block's old value.
struct DueBlocks {
  float* due;
  glm::ivec3 first, size;  // index of the first block; number of blocks along each axis
  float path_length;       // voxels, path length at the end of the sweep
  float slip;              // voxels, largest rounding error of a sample's computed depth

  /// Path lengths of the blocks along z from the one at `voxel` to the one at `last_z`; null: some are not stored.
  float* row(const glm::ivec3& voxel, int last_z) const noexcept;
};

inline constexpr float kTop = 5e-4f;  // voxels, allowed error of a sample's largest depth during a motion
// voxels; for shorter motions only the final pose is used, which takes a seventh less time
inline constexpr float kSlow = 0.05f;
// voxels; nearer than this to a corner of the meridian, rounding errors dominate the normal
inline constexpr float kNear = 0.01f;

/// Distance r from the axis beyond which the largest depth need not be searched: if one piece is nearest during a
/// motion of length L, a sample's depth exceeds that at the motion's ends by at most L² / (4 r), which is below kTop.
inline float smooth_from(const Straight& path, const MeridianPiece& piece) {
  const float least = path.longest * path.longest / (3.6f * kTop);
  // + 4: a sample is at most 3 voxels (kInner) below an arc, so it is at least `least` + 1 from the arc's centre.
  return piece.radius == 0.0f || piece.radius > least + 4 ? least : kNoEnd;
}

/// List of samples that were cut at the motion's end, but may have been deeper in the head earlier in the motion.
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
