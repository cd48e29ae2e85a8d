// The distance field of what stays when a loose piece is taken out.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::haptics {

/// Voxels around a piece whose distances it may have made.
inline constexpr int kPieceMargin = 4;

/// A dense box of samples, z running quickest: index (x·size.y + y)·size.z + z.
struct PieceBox {
  glm::ivec3 size{0};
  std::vector<float> distance;      // voxels
  std::vector<std::uint8_t> loose;  // 1: a sample of the piece

  std::size_t at(const glm::ivec3& p) const {
    return (static_cast<std::size_t>(p.x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(p.y)) *
               static_cast<std::size_t>(size.z) +
           static_cast<std::size_t>(p.z);
  }
};

/// The distances without the piece, voxels: the piece's own samples, and those of the air that it alone made, become
/// what the rest of the tissue makes of them; all others stay to the bit. Never less than before.
std::vector<float> without_piece(const PieceBox& box);

}  // namespace typodont::haptics
