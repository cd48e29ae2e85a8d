// Computes the distance field that remains after a loose piece is removed.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::haptics {

/// voxels; the removal of a loose piece changes no sample of air that is farther from the piece than this
inline constexpr int kPieceMargin = 4;

/// A dense box of samples; z runs fastest: index (x·size.y + y)·size.z + z.
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

/// Returns the distances (voxels) without the piece. The piece's samples, and samples of air nearest to the piece, get
/// their distance to the remaining tissue; all other samples keep their bits. No distance becomes smaller.
std::vector<float> without_piece(const PieceBox& box);

}  // namespace typodont::haptics
