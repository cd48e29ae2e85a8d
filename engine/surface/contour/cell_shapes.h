// Table of the 256 sign configurations of a cube: the edges that the surface crosses, and the connections between the
// crossings.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace typodont::surface {

// Numbering of corners, edges and faces. Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4a + k runs along
// axis a; k = u + 2v, where (u, v) is the edge's position along the other two axes, in the order y,z for a = x; x,z for
// a = y; x,y for a = z. Face 2a + side is perpendicular to axis a.

/// Shape of the surface inside a cell: a set of discs ("patches"), each bounded by a loop of crossed edges.
struct CellShape {
  std::uint8_t patches = 0;
  std::uint8_t edges = 0;                // number of the cell's edges that the surface crosses
  std::array<std::uint8_t, 12> edge{};   // indices of the edges that the surface crosses
  std::array<std::uint8_t, 12> patch{};  // for each edge: the patch (piece of surface) that contains its crossing
};

/// All shapes. Numbers 0..255 are the sign configurations of a cell (bit c is set if corner c is solid). In these
/// shapes, solid corners that are diagonally opposite on a face are not connected. Then the surfaces of two
/// neighbouring cells may meet in two arcs on their common face, and an edge of the mesh would have four polygons. In
/// this case, both cells use a flipped shape, which connects the solid corners across this face. Both cells decide
/// equally, because the decision depends only on their two sign configurations. (Wenger 2013, sec. 3.3: manifold dual
/// contouring)
class CellShapes {
 public:
  static const CellShapes& get();

  const CellShape& operator[](int shape) const { return shapes_[static_cast<std::size_t>(shape)]; }
  /// Returns the faces on which the surface has two arcs of the same patch (piece of surface); bit f is set for face f.
  std::uint8_t flippable_faces(int config) const { return doubtful_[static_cast<std::size_t>(config)]; }
  /// Returns the shape number for a configuration with flipped faces; `flipped_faces` is a subset of flippable_faces().
  int flipped(int config, int flipped_faces) const {
    return flipped_[static_cast<std::size_t>(config)][static_cast<std::size_t>(flipped_faces)];
  }
  /// Returns true if the shape has one patch (piece of surface), and no face with four crossings. Then the surface is a
  /// disc, even if the cell is merged with its neighbours (Ju et al. 2002).
  bool simple(int config) const { return simple_[static_cast<std::size_t>(config)]; }

 private:
  CellShapes();
  std::vector<CellShape> shapes_;
  std::array<std::uint8_t, 256> doubtful_{};
  std::array<std::array<std::uint16_t, 64>, 256> flipped_{};
  std::array<bool, 256> simple_{};
};

}  // namespace typodont::surface
