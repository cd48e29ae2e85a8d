// A part of a head's way on which samples go straight through it, as it sees them. A head is convex, so how deep a
// sample lies in it is concave along such a way and has one top. Private to sweeps.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"

namespace typodont::haptics {

/// From one pose to another, either way: a sample at p in the head at first comes to p + shift + turn p. Voxels.
struct Straight {
  HeadPose from;
  float shift[3], turn[9];  // turn by columns
  const MeridianPiece* pieces;
  int count;
  float turned;   // by how much the ways of samples a voxel apart differ, at most
  float longest;  // way of any sample that a cut may change
  float slip;     // more than a tangent errs
};
Straight straight_way(const Pose& X_VA, const Pose& X_VB, const MeridianPiece* pieces, int count, double reach);

inline constexpr float kTop = 5e-4f;  // voxels; how much deeper a sample may have lain on the way than what is found
inline constexpr float kSlow =
    0.05f;  // voxels; of a way of no more than this only what its end takes is taken, which costs a seventh less
inline constexpr float kNear = 0.01f;  // voxels; nearer to a corner the direction from it would be rounding

/// Farther than this from the axis the tangents at both ends of a way meet too little above them to count (by way² / 4
/// r), where one piece alone is the closest all along it.
inline float smooth_from(const Straight& way, const MeridianPiece& piece) {
  const float least = way.longest * way.longest / (3.6f * kTop);
  return piece.radius == 0.0f || piece.radius > least + 4 ? least : kNoEnd;  // no deeper than 3 anything is cut
}

/// Samples that were perhaps deeper in the head on its way than at the end of it, where they were cut before.
struct Tops {
  static constexpr int kRoom = 1024;

  Straight back;  // from the end of the way
  PerTissue* removed;
  bool changed = false;
  int count = 0;
  float x[kRoom], y[kRoom], z[kRoom];  // from the base of that end
  float* at[kRoom];
  std::uint8_t label[kRoom];

  Tops(const Straight& way_back, PerTissue* taken) : back(way_back), removed(taken) {}
  /// Before as many samples are read as may be added.
  void make_room(int samples) noexcept {
    if (count > kRoom - samples) carve();
  }
  void add(float at_x, float at_y, float at_z, float* sample, std::uint8_t tissue) noexcept {
    x[count] = at_x, y[count] = at_y, z[count] = at_z, at[count] = sample, label[count++] = tissue;
  }
  /// Raises them to that, and forgets them.
  void carve() noexcept;
};

}  // namespace typodont::haptics
