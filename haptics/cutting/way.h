// Describes a short motion of a head as seen from the head: the samples move along straight lines through the head. A
// head is convex, so the depth of a sample in the head is a concave function along its line and has only one maximum.
// Private to haptics/cutting.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"
#include "haptics/cutting/removed.h"

namespace typodont::haptics {

/// The motion of samples between two poses of the head, forward or backward. A sample at the position p in the head's
/// frame moves to p + shift + turn p. Lengths in voxels.
struct Straight {
  HeadPose from;
  float shift[3], turn[9];  // motion p → p + shift (voxels) + turn p; matrix: column by column
  const MeridianPiece* pieces;
  int count;
  float turned;   // voxels, upper bound of the difference between the paths of two samples that are one voxel apart
  float longest;  // voxels, length of the longest path of any sample that a cut may change
  float slip;     // voxels, upper bound of the error of a tangent to the curve of the depth along the path
  // For a motion along the axis of a cylinder: a sample does not change if z > still_above and rho + z > still_beyond
  // in the head's frame. Such a sample lies above the rim of the end, and nearer to the flank than to the end, during
  // the whole motion. kNoEnd for every other motion.
  float still_above = kNoEnd, still_beyond = kNoEnd;
  // Second-order term of the path while the head rotates: at the fraction s of the path, a sample deviates from the
  // straight line by s (s - 1) (bend_shift + bend_turn p).
  float bend_shift[3] = {}, bend_turn[9] = {};
  // voxels, largest deviation of a sample's path from the straight line; 0 without the second-order term
  float bent = 0;
};
Straight straight_way(const Pose& X_VA, const Pose& X_VB, const MeridianPiece* pieces, int count, double reach);

/// Adds the second-order term to a path that starts at pose A. `X_VM`: pose in the middle of the path.
void bend(Straight& way, const Pose& X_VA, const Pose& X_VM, double reach);
/// Returns true if line `i` of the meridian is the flank of a cylinder with a round end below it.
bool has_round_end(const MeridianPiece* pieces, int i);

/// The path length of the head at which each block of 4 × 4 × 8 voxels must be examined again (CutFront); z is the
/// fastest index. If a sweep cannot compute this path length for a block, the stored value stays unchanged.
struct DueBlocks {
  float* due;
  glm::ivec3 first, size;  // first block of samples, and number of blocks of samples along each axis
  float way;               // voxels, path length of the head at the end of the sweep
  float slip;              // voxels, largest rounding error of a depth

  /// Returns a pointer to the path lengths at which the blocks of a row along z must be examined again. The row begins
  /// with the block at `voxel` and ends with the block that contains the height `last_z`. Null if any of these values
  /// is unknown.
  float* row(const glm::ivec3& voxel, int last_z) const noexcept;
};

inline constexpr float kTop = 5e-4f;  // voxels, tolerance of the computed largest depth of a sample
// voxels; for a motion of at most this length, a cut uses only the head's final pose, which saves a seventh of the
// cut's computing time
inline constexpr float kSlow = 0.05f;
// voxels; if a point is nearer than this to a corner of the head's outline, rounding errors dominate the computed
// direction from the corner to the point
inline constexpr float kNear = 0.01f;

/// Returns the distance r from the axis beyond which the maximum of a sample's depth on its path need not be searched.
/// Reason: let L be the length of the path, on which a single piece of the meridian is nearest. The depth on the path
/// then exceeds the depths at both ends by at most about L² / (4 r). This is below the tolerance kTop.
inline float smooth_from(const Straight& way, const MeridianPiece& piece) {
  const float least = way.longest * way.longest / (3.6f * kTop);
  // The margin of 4 voxels includes the depth of a cut, which is at most 3 voxels.
  return piece.radius == 0.0f || piece.radius > least + 4 ? least : kNoEnd;
}

/// Samples that may have been deeper in the head during the motion than at the motion's end. The cut at the motion's
/// end has already been made.
struct PathMaxima {
  static constexpr int kRoom = 1024;

  Straight back;  // path from the end of the motion back to its beginning
  RemovedVolume* removed;
  bool changed = false;
  int count = 0;
  // voxels, positions of the samples, relative to HeadPose::base of the motion's last pose
  float x[kRoom], y[kRoom], z[kRoom];
  float* at[kRoom];
  std::uint8_t label[kRoom];

  PathMaxima(const Straight& way_back, RemovedVolume* taken) : back(way_back), removed(taken) {}
  /// Call this function before `samples` samples are read. If the list has too little space for all of them, the listed
  /// samples are cut now and the list is emptied.
  void make_room(int samples) noexcept {
    if (count > kRoom - samples) carve();
  }
  void add(float at_x, float at_y, float at_z, float* sample, std::uint8_t tissue) noexcept {
    x[count] = at_x, y[count] = at_y, z[count] = at_z, at[count] = sample, label[count++] = tissue;
  }
  /// Raises the listed samples to their largest depth and empties the list.
  void carve() noexcept;
};

}  // namespace typodont::haptics
