// The 256 sign configurations of a cube: crossed edges and their connections.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace typodont::surface {

// Corner c at (c & 1, c >> 1 & 1, c >> 2). Edge 4a + k along a, k = u + 2v on the other axes (y,z; x,z; x,y). Face 2a +
// side across a.

/// Discs ("patches"), each in a loop of crossed edges.
struct CellShape {
  std::uint8_t patches = 0;
  std::uint8_t edges = 0;                // number of the cell's edges that the surface crosses
  std::array<std::uint8_t, 12> edge{};   // indices of the edges that the surface crosses
  std::array<std::uint8_t, 12> patch{};  // of each edge's crossing
};

/// 0..255: configurations (bit c: corner c solid), diagonal solid corners unconnected. If two cells would meet in two
/// arcs on a face, both use a flipped shape that connects them, decided alike from both configurations (Wenger 2013,
/// sec. 3.3: manifold dual contouring).
class CellShapes {
 public:
  static const CellShapes& get();

  const CellShape& operator[](int shape) const { return shapes_[static_cast<std::size_t>(shape)]; }
  /// Bit f: face f has two arcs of one patch.
  std::uint8_t flippable_faces(int config) const { return doubtful_[static_cast<std::size_t>(config)]; }
  /// `flipped_faces`: of flippable_faces().
  int flipped(int config, int flipped_faces) const {
    return flipped_[static_cast<std::size_t>(config)][static_cast<std::size_t>(flipped_faces)];
  }
  /// One patch, no face with four crossings: a disc, also merged (Ju et al. 2002).
  bool simple(int config) const { return simple_[static_cast<std::size_t>(config)]; }

 private:
  CellShapes();
  std::vector<CellShape> shapes_;
  std::array<std::uint8_t, 256> doubtful_{};
  std::array<std::array<std::uint16_t, 64>, 256> flipped_{};
  std::array<bool, 256> simple_{};
};

}  // namespace typodont::surface
