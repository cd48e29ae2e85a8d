// A ball of filling as plain data, and its effect on a block of samples. Private to haptics.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"

namespace typodont::haptics {

class Fill;
class FreshLabels;

/// A ball of filling. Positions are in voxels, relative to the base voxel (a voxel near the instrument's head).
struct FillBall {
  HeadPose head;
  // pieces of the outline of the shape that no filling may enter: the head, and its path out of the tissue
  MeridianPiece pieces[HeadField::kMaxPieces];
  // set of all pieces of the outline that no filling may enter, one bit for each piece
  unsigned all_pieces;
  float x, y, z, radius;
  Tissue label;
  const Fill* filling;  // the filling to which the ball belongs; the kernel reads its limit
};

struct FillBlock {
  // `first`: first sample of the block, relative to the base voxel (origin of the ball's positions); `size`: number of
  // samples along each axis
  glm::ivec3 first, size;
  float* distance;
  Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
};

/// Adds the filling to a block of samples: reduces each distance to the distance from the filling, if this is smaller
/// than the old one. Fill::lower() explains the arguments.
bool lower_block(const FillBall& ball, const FillBlock& block, PerTissue* added, FreshLabels* fresh) noexcept;

}  // namespace typodont::haptics
