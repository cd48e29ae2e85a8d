// Meridian and pose of a head as floats. Private to haptics.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A piece (line or arc) of HeadField, with outward normals at both ends and the length of a line.
struct MeridianPiece {
  float ax, az, bx, bz, dx, dz, inverse2, cx, cz, radius;
  float nax, naz, nbx, nbz;
  float length;
  float ux, uz, wx, wz;  // vectors from an arc's centre to its ends
  // At the corners a and b: tan(φ/2), where φ is the angle between the neighbouring normals.
  float corner_a, corner_b;
};
// The kind of a block or group of samples tells which pieces of the meridian can be nearest to the samples. One piece:
// its index, which is below kManyPieces. Several pieces: kManyPieces plus a bit mask of the pieces.
inline constexpr int kManyPieces = HeadField::kMaxPieces;

/// Pose of a head in voxels, relative to the voxel `base`, which is so near that floats are precise enough.
struct HeadPose {
  glm::ivec3 base;
  float p[3];  // voxels, the head's centre relative to `base`
  float R[9];  // rotation from V to T, column by column
};

/// The samples from which a head removes tissue: arrays of their values, and the box of voxels that the arrays contain.
struct HeadTarget {
  glm::ivec3 lo, size;
  float* distance;
  std::ptrdiff_t stride_x, stride_y;
  const Tissue* tissue;
};

// voxels, represents an infinite length; for example, a sample that can never change has this safe travel
inline constexpr float kNoEnd = 1e9f;

void flatten(const HeadField& head, MeridianPiece* pieces);
HeadPose head_pose(const Pose& X_VT);

}  // namespace typodont::haptics
