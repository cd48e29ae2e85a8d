// One brick of distance field → the vertices of its surface and which cell holds which: everything that follows from
// the brick's own samples alone. Polygons join cells of several bricks and come later (surface_mesher.cpp).
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
  glm::vec3 position{0};  // voxels, index space
  glm::vec3 normal{0};    // unit, out of the solid
  Tissue tissue[2]{};     // the two commonest around it, the commonest first
  float second = 0;       // 0..0.5, share of the second among the two
  bool crease = false;    // on a sharp edge: `normal` is only a mean
  bool gentle = false;    // that mean is what it is shaded by: no two of its cell's normals differ by more than 64°
};

struct BrickContour {
  static constexpr int kCells = FieldBrick::kCells;
  static constexpr int cell_index(int x, int y, int z) { return (x * kCells + y) * kCells + z; }

  struct Cell {
    std::uint16_t vertex;  // first of its patches
    std::uint16_t shape;   // of CellShapes
  };
  /// A crossed edge whose base is cell corner `cell` of this brick.
  struct Edge {
    std::uint16_t cell : 12;
    std::uint16_t axis : 2;
    std::uint16_t solid_base : 1;
  };

  glm::ivec3 key{0};
  std::array<std::uint64_t, 64> active{};  // bit per cell: the surface passes through it
  std::array<std::uint16_t, 64> before{};  // active cells in the words before
  std::vector<Cell> cells;                 // the active ones, in order
  std::vector<ContourVertex> vertices;
  std::vector<Edge> edges;

  bool empty() const { return cells.empty(); }
  /// Number in `cells`, or -1 where the surface does not pass.
  int find(int cell) const {
    const std::uint64_t word = active[static_cast<std::size_t>(cell >> 6)];
    const std::uint64_t bit = std::uint64_t{1} << (cell & 63);
    if (!(word & bit)) return -1;
    return before[static_cast<std::size_t>(cell >> 6)] + std::popcount(word & (bit - 1));
  }
};

/// Works through bricks one at a time; keeps its scratch memory between them.
class Contourer {
 public:
  Contourer();
  ~Contourer();
  /// `tolerance` in voxels: cells are merged, in blocks of 2³ to 16³, while the surface they stand for stays within it.
  /// Negative: never.
  void contour(const FieldBrick& brick, float tolerance, BrickContour& out);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace typodont::surface
