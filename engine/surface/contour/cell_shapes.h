// What a cube of eight signs looks like: which of its edges the surface crosses, and which crossings belong together.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace typodont::surface {

// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4a + k runs along axis a; k = u + 2v, where (u, v) is
// its place along the other two axes in the order y,z for a = x; x,z for a = y; x,y for a = z.
// Face 2a + side lies across axis a.

/// The surface inside a cell is a set of discs ("patches"), each bounded by a loop of crossed edges.
struct CellShape {
  std::uint8_t patches = 0;
  std::uint8_t edges = 0;                // how many edges are crossed
  std::array<std::uint8_t, 12> edge{};   // which
  std::array<std::uint8_t, 12> patch{};  // by edge number: the patch its crossing belongs to
};

/// All shapes. Shape 0..255 is the sign configuration (bit c set: corner c is solid) with solid corners that meet only
/// across a face's diagonal kept apart. Where that would let two cells touch along two arcs of one face (a dual edge
/// with four polygons), both cells use the flipped shape, which joins the solid across that face instead; the decision
/// needs only the two configurations, so both cells reach it alone. (Wenger 2013, sec. 3.3: manifold dual contouring)
class CellShapes {
 public:
  static const CellShapes& get();

  const CellShape& operator[](int shape) const { return shapes_[static_cast<std::size_t>(shape)]; }
  /// Faces on which both arcs belong to one patch: bit f for face f.
  std::uint8_t doubtful_faces(int config) const { return doubtful_[static_cast<std::size_t>(config)]; }
  /// Shape number of a configuration whose faces in `flipped` (a subset of the doubtful ones) are flipped.
  int flipped(int config, int flipped_faces) const {
    return flipped_[static_cast<std::size_t>(config)][static_cast<std::size_t>(flipped_faces)];
  }
  /// One patch and no face with four crossings: the surface is a disc whatever the resolution (Ju et al. 2002).
  bool simple(int config) const { return simple_[static_cast<std::size_t>(config)]; }

 private:
  CellShapes();
  std::vector<CellShape> shapes_;
  std::array<std::uint8_t, 256> doubtful_{};
  std::array<std::array<std::uint16_t, 64>, 256> flipped_{};
  std::array<bool, 256> simple_{};
};

}  // namespace typodont::surface
