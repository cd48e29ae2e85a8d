// Heads other than balls: meridian as floats, and pose. Private to haptics/cutting.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// HeadField::Piece with outward normals at both ends; a line's length.
struct MeridianPiece {
  float ax, az, bx, bz, dx, dz, inverse2, cx, cz, radius;
  float nax, naz, nbx, nbz;
  float length;
  float ux, uz, wx, wz;  // vectors from an arc's centre to its ends
  // Corners a and b: tan(φ/2), φ between the neighbouring normals.
  float corner_a, corner_b;
};
// Below: one smooth piece that is nearest. From there: plus a bit per piece that can be.
inline constexpr int kManyPieces = HeadField::kMaxPieces;

/// Voxels from `base`, near enough for floats.
struct HeadPose {
  glm::ivec3 base;
  float p[3];  // voxels, head's centre from `base`
  float R[9];  // V to T, by column
};

/// From which a head removes.
struct HeadTarget {
  glm::ivec3 lo, size;
  float* distance;
  std::ptrdiff_t stride_x, stride_y;
  const Tissue* tissue;
};

// voxels of slack: never
inline constexpr float kNoEnd = 1e9f;

void flatten(const HeadField& head, MeridianPiece* pieces);
HeadPose head_pose(const Pose& X_VT);

}  // namespace typodont::haptics
