// A head that is no ball as its kernels see it: the pieces of its meridian, in floats, and a pose. Private to
// haptics/cutting.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A piece of the meridian in floats: HeadField::Piece with its outward normals at either end; of a line its length.
struct MeridianPiece {
  float ax, az, bx, bz, dx, dz, inverse2, cx, cz, radius;
  float nax, naz, nbx, nbz;
  float length;
  float ux, uz, wx, wz;      // from an arc's centre to its ends
  float corner_a, corner_b;  // tan(φ/2) where its outward normal turns by φ to its neighbour's
};
inline constexpr int kManyPieces =
    HeadField::kMaxPieces;  // kinds of groups: one smooth piece, or from here on a set of them

/// A pose of the head in voxels, counted from a voxel nearby, so that floats keep their digits.
struct HeadPose {
  glm::ivec3 base;
  float p[3];  // the head from there
  float R[9];  // from V to T, by columns
};

/// A box of samples that a head is cut out of.
struct HeadTarget {
  glm::ivec3 lo, size;
  float* distance;
  std::ptrdiff_t stride_x, stride_y;
  const Tissue* tissue;
};

inline constexpr float kNoEnd = 1e9f;  // a slack that never ends

void flatten(const HeadField& head, MeridianPiece* pieces);
HeadPose head_pose(const Pose& X_VT);

}  // namespace typodont::haptics
