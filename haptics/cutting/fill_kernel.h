// A ball of filling as plain data, and its effect on a block of samples. Private to haptics.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"

namespace typodont::haptics {

class Fill;
class FreshLabels;

/// A ball of filling. Positions are relative to the head pose's base, in voxels.
struct FillBall {
  HeadPose head;
  MeridianPiece pieces[HeadField::kMaxPieces];  // pieces of the head, and of its path out of the tissue
  unsigned all_pieces;                          // one bit for each piece
  float x, y, z, radius;
  Tissue label;
  const Fill* filling;  // the filling to which the ball belongs; the kernel reads its limit
};

struct FillBlock {
  glm::ivec3 first, size;  // first sample of the block, relative to the base
  float* distance;
  Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
};

/// Lowers the distances of a block; see Fill::lower().
bool lower_block(const FillBall& ball, const FillBlock& block, PerTissue* added, FreshLabels* fresh) noexcept;

}  // namespace typodont::haptics
