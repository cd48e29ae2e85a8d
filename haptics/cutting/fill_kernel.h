// As plain data. Private to haptics.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"
#include "haptics/cutting/meridian.h"

namespace typodont::haptics {

class Fill;
class FreshLabels;

/// Voxels from the base voxel near the instrument's head.
struct FillBall {
  HeadPose head;
  // where no filling may be: head and its way out
  MeridianPiece pieces[HeadField::kMaxPieces];
  // all of these, a bit each
  unsigned all_pieces;
  float x, y, z, radius;
  Tissue label;
  const Fill* filling;  // whose limit the kernel reads
};

struct FillBlock {
  // `first`: from the base voxel; `size`: samples per axis
  glm::ivec3 first, size;
  float* distance;
  Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
};

/// The smaller of old distance and filling's; see Fill::lower().
bool lower_block(const FillBall& ball, const FillBlock& block, PerTissue* added, FreshLabels* fresh) noexcept;

}  // namespace typodont::haptics
