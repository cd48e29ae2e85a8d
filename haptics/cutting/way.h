// A short motion seen from the head: samples on lines, depths concave with one maximum. Private to haptics/cutting.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"
#include "haptics/cutting/removed.h"

namespace typodont::haptics {

/// Between two poses, either way: p to p + shift + turn p, T, voxels.
struct Straight {
  HeadPose from;
  float shift[3], turn[9];  // by column; shift in voxels
  const MeridianPiece* pieces;
  int count;
  float turned;   // voxels, of paths one voxel apart
  float longest;  // voxels, of what a cut may change
  float slip;     // voxels, of a tangent to the depth
  // Along a cylinder's axis: unchanged if z > still_above and rho + z > still_beyond, T: above the rim and nearer to
  // the flank throughout. Otherwise kNoEnd.
  float still_above = kNoEnd, still_beyond = kNoEnd;
  // At fraction s off the line by s (s - 1) (bend_shift + bend_turn p), by rotation.
  float bend_shift[3] = {}, bend_turn[9] = {};
  // voxels off the line; 0 without it
  float bent = 0;
};
Straight straight_way(const Pose& X_VA, const Pose& X_VB, const MeridianPiece* pieces, int count, double reach);

/// For a path from A. `X_VM`: in its middle.
void bend(Straight& way, const Pose& X_VA, const Pose& X_VM, double reach);
/// With a round end below.
bool has_round_end(const MeridianPiece* pieces, int i);

/// CutFront, per 4 × 4 × 8 voxels, z fastest. Unchanged where a sweep cannot tell.
struct DueBlocks {
  float* due;
  glm::ivec3 first, size;  // first one, and number per axis
  float way;               // voxels, at the sweep's end
  float slip;              // voxels, largest rounding error of a depth

  /// Along z from the block at `voxel` to that of `last_z`. Null: some are unknown.
  float* row(const glm::ivec3& voxel, int last_z) const noexcept;
};

inline constexpr float kTop = 5e-4f;  // voxels, of the largest depth
// voxels; shorter motions use the final pose, a seventh less time
inline constexpr float kSlow = 0.05f;
// voxels from a corner, where rounding dominates the direction
inline constexpr float kNear = 0.01f;

/// r from the axis beyond which no search is needed: over length L below one piece, at most L² / (4 r) above the ends,
/// below kTop.
inline float smooth_from(const Straight& way, const MeridianPiece& piece) {
  const float least = way.longest * way.longest / (3.6f * kTop);
  // 4 voxels: a cut reaches 3.
  return piece.radius == 0.0f || piece.radius > least + 4 ? least : kNoEnd;
}

/// Perhaps deeper during the motion; its end has been cut.
struct PathMaxima {
  static constexpr int kRoom = 1024;

  Straight back;  // end to start
  RemovedVolume* removed;
  bool changed = false;
  int count = 0;
  // voxels from HeadPose::base of the last pose
  float x[kRoom], y[kRoom], z[kRoom];
  float* at[kRoom];
  std::uint8_t label[kRoom];

  PathMaxima(const Straight& way_back, RemovedVolume* taken) : back(way_back), removed(taken) {}
  /// Before reading `samples`; a full list is cut and emptied.
  void make_room(int samples) noexcept {
    if (count > kRoom - samples) carve();
  }
  void add(float at_x, float at_y, float at_z, float* sample, std::uint8_t tissue) noexcept {
    x[count] = at_x, y[count] = at_y, z[count] = at_z, at[count] = sample, label[count++] = tissue;
  }
  /// And empties the list.
  void carve() noexcept;
};

}  // namespace typodont::haptics
