// Filling material as plain data for the kernel. Private to haptics.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"

namespace typodont::haptics {

class Fill;
class FreshLabels;

/// Input of lower_block(): a ball of filling. Positions in voxels, relative to a base voxel near the head.
struct FillBall {
  HeadPose head;
  // meridian of the head; no filling may enter the head, or the path on which the head can be withdrawn
  MeridianPiece pieces[HeadField::kMaxPieces];
  // bit mask of all pieces of the meridian
  unsigned all_pieces;
  float x, y, z, radius;
  Tissue label;
  const Fill* filling;  // gives the solid that limits the filling
};

struct FillBlock {
  // `first`: position relative to the base voxel; `size`: number of samples along each axis
  glm::ivec3 first, size;
  float* distance;
  Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
};

/// Lowers each sample to the filling's distance; see Fill::lower().
bool lower_block(const FillBall& ball, const FillBlock& block, PerTissue* added, FreshLabels* fresh) noexcept;

}  // namespace typodont::haptics
