// Data of a head that is not a ball, for the kernels: the pieces of its meridian (outline) as floats, and a pose.
// Private to haptics/cutting.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/base/pose.h"
#include "engine/contract/tissue.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A piece (line or arc) of the meridian as floats: HeadField::Piece with its outward normals at both ends; for a line
/// also its length.
struct MeridianPiece {
  float ax, az, bx, bz, dx, dz, inverse2, cx, cz, radius;
  float nax, naz, nbx, nbz;
  float length;
  float ux, uz, wx, wz;  // vectors from an arc's centre to its ends
  // For the corners at the two ends of the piece (a and b): tan(φ/2), where φ is the angle between the normals of this
  // piece and of the neighbouring piece at the common corner.
  float corner_a, corner_b;
};
// The kind of a group of samples states which pieces of the meridian can be nearest to the samples. A kind below this
// value is the index of a single smooth piece. Any other kind is this value plus a set of pieces (one bit each).
inline constexpr int kManyPieces = HeadField::kMaxPieces;

/// A pose of the head, in voxels relative to `base`. `base` is a voxel near the head, so that floats are precise
/// enough.
struct HeadPose {
  glm::ivec3 base;
  float p[3];  // voxels, position of the head's centre relative to `base`
  float R[9];  // rotation from the frame V of the voxels to the frame T of the head, column by column
};

/// A box of samples from which a head removes tissue.
struct HeadTarget {
  glm::ivec3 lo, size;
  float* distance;
  std::ptrdiff_t stride_x, stride_y;
  const Tissue* tissue;
};

// voxels, a value for the slack (motion until a sample can change) that means "never"
inline constexpr float kNoEnd = 1e9f;

void flatten(const HeadField& head, MeridianPiece* pieces);
HeadPose head_pose(const Pose& X_VT);

}  // namespace typodont::haptics
