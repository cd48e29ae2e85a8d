// Computes the distance field after a loose piece was removed.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::haptics {

/// voxels; air samples up to this far from the piece may change
inline constexpr int kPieceMargin = 4;

/// Samples of a box; index: voxel_index().
struct PieceBox {
  glm::ivec3 size{0};
  std::vector<float> distance;      // voxels, distance of each sample
  std::vector<std::uint8_t> loose;  // for each sample: 1 if it belongs to the piece, otherwise 0
};

/// Returns the distances after the removal of the piece, voxels. Samples of the piece, and air samples whose nearest
/// tissue was the piece, get the distance to the remaining tissue; all others do not change. No distance gets smaller.
std::vector<float> without_piece(const PieceBox& box);

}  // namespace typodont::haptics
