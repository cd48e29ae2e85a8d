// A ball of filling, plain, and what it makes of a block of samples. Private to the haptics.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"

namespace typodont::haptics {

class Fill;
class FreshLabels;

/// Positions count from the head pose's base, in voxels.
struct FillBall {
  HeadPose head;
  MeridianPiece pieces[HeadField::kMaxPieces];  // of the head and its way out
  unsigned all_pieces;                          // a bit for each
  float x, y, z, radius;
  Tissue label;
  const Fill* filling;  // knows the tool's limit
};

struct FillBlock {
  glm::ivec3 first, size;  // its first sample, from the base
  float* distance;
  Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
};

/// See Fill::lower().
bool lower_block(const FillBall& ball, const FillBlock& block, PerTissue* added, FreshLabels* fresh) noexcept;

}  // namespace typodont::haptics
