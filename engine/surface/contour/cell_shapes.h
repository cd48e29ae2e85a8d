// The 256 sign configurations of a cube's corners: which edges the surface crosses, and which crossings it joins.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace typodont::surface {

// Corner c lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4a + u + 2v lies along axis a at (u, v) of the two other axes
// (y,z; x,z; x,y). Face 2a + side is perpendicular to axis a.

/// Patches of surface in a cell. Each is a disc, whose border is a loop through crossed edges.
struct CellShape {
  std::uint8_t patches = 0;
  std::uint8_t edges = 0;                // number of the cell's edges that the surface crosses
  std::array<std::uint8_t, 12> edge{};   // indices of the edges that the surface crosses
  std::array<std::uint8_t, 12> patch{};  // for each crossed edge: index of the surface patch
};

/// Shapes 0..255 belong to the sign configurations (bit c: corner c is solid). Where two cells would share two arcs on
/// a face, both use a flipped shape (manifold dual contouring, Wenger 2013, sec. 3.3).
class CellShapes {
 public:
  static const CellShapes& get();

  const CellShape& operator[](int shape) const { return shapes_[static_cast<std::size_t>(shape)]; }
  /// Returns a bit per face, set if the face has two arcs of the same patch.
  std::uint8_t flippable_faces(int config) const { return doubtful_[static_cast<std::size_t>(config)]; }
  /// Shape that joins the four crossings on each of these faces (some of flippable_faces()) by the other two arcs.
  int flipped(int config, int flipped_faces) const {
    return flipped_[static_cast<std::size_t>(config)][static_cast<std::size_t>(flipped_faces)];
  }
  /// Returns true if the cell has one patch and no face with four crossings. The surface is then a disc, also after
  /// merging (Ju et al. 2002).
  bool simple(int config) const { return simple_[static_cast<std::size_t>(config)]; }

 private:
  CellShapes();
  std::vector<CellShape> shapes_;
  std::array<std::uint8_t, 256> doubtful_{};
  std::array<std::array<std::uint16_t, 64>, 256> flipped_{};
  std::array<bool, 256> simple_{};
};

}  // namespace typodont::surface
