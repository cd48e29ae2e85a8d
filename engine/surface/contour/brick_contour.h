// Vertices and cells of one brick (16³ cells), computed from its own samples. surface_mesher.cpp joins them to
// polygons.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::surface {

struct ContourVertex {
  glm::vec3 position{0};  // voxels, position of the vertex in the voxel frame
  glm::vec3 normal{0};    // unit normal, pointing out of the solid
  float second = 0;       // 0..0.5, fraction of the second tissue, tissue[1]
  Tissue tissue[2]{};     // the two most frequent tissues around the vertex, the more frequent one first
  bool crease = false;    // true at a sharp edge; `normal` is then the mean of both sides
  // true: the normals of the crease's sides differ by less than 64°; small triangles here use the mean of the normals
  bool gentle = false;
};

struct BrickContour {
  static constexpr int kCells = FieldBrick::kCells;
  static constexpr int cell_index(int x, int y, int z) { return (x * kCells + y) * kCells + z; }

  struct Cell {
    std::uint16_t vertex;  // index in `vertices` of the cell's first vertex (one for each piece of its surface)
    std::uint16_t shape;   // index of the cell's shape in CellShapes
  };
  /// An edge of the grid that the surface crosses. `cell` is the cell whose lowest corner is the edge's start.
  struct Edge {
    std::uint16_t cell : 12;
    std::uint16_t axis : 2;
    std::uint16_t solid_base : 1;
  };

  glm::ivec3 key{0};
  std::array<std::uint64_t, 64> active{};  // one bit per cell, set if the cell contains surface
  std::array<std::uint16_t, 64> before{};  // for each word of `active`: number of set bits in earlier words
  std::vector<Cell> cells;                 // the active cells, in the order of their bits
  std::vector<ContourVertex> vertices;
  std::vector<Edge> edges;

  bool empty() const { return cells.empty(); }
  /// Returns the index of a cell in `cells`, or -1 if it contains no surface.
  int find(int cell) const {
    const std::uint64_t word = active[static_cast<std::size_t>(cell >> 6)];
    const std::uint64_t bit = std::uint64_t{1} << (cell & 63);
    if (!(word & bit)) return -1;
    return before[static_cast<std::size_t>(cell >> 6)] + std::popcount(word & (bit - 1));
  }
};

/// Contours one brick at a time and reuses its memory.
class Contourer {
 public:
  Contourer();
  ~Contourer();
  /// Merges blocks of up to 16³ cells if the error stays within `tolerance` (voxels). Negative: does not merge.
  void contour(const FieldBrick& brick, float tolerance, BrickContour& out);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace typodont::surface
