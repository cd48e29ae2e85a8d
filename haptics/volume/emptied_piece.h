// The field after a loose piece is removed.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::haptics {

/// voxels from the piece, within which air may change
inline constexpr int kPieceMargin = 4;

/// z fastest: (x·size.y + y)·size.z + z.
struct PieceBox {
  glm::ivec3 size{0};
  std::vector<float> distance;      // voxels, distance of each sample
  std::vector<std::uint8_t> loose;  // 1 for each sample of the piece

  std::size_t at(const glm::ivec3& p) const {
    return (static_cast<std::size_t>(p.x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(p.y)) *
               static_cast<std::size_t>(size.z) +
           static_cast<std::size_t>(p.z);
  }
};

/// Voxels. The piece, and air nearest to it, get the distance to what remains; the rest keeps its bits. Nothing gets
/// smaller.
std::vector<float> without_piece(const PieceBox& box);

}  // namespace typodont::haptics
