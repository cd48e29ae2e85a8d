// Copies, orientation, holes, shells.
#pragma once

#include <vector>

#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

/// Same corners in the same order.
void drop_copies(Mesh& mesh, MeshRepairs& repairs);

/// Neighbours list their edge oppositely; fewest reversals per piece.
void orient(Mesh& mesh, MeshRepairs& repairs);

/// Path along edges with an odd number of triangles, in their direction.
struct Border {
  std::vector<int> points;
  double length = 0;   // m, length of the border
  bool closed = true;  // false: inconsistent triangles
};
std::vector<Border> borders(const Mesh& mesh);

/// Fan around its centre; adds places, does not count.
void close_border(Mesh& mesh, const Border& border, MeshRepairs& repairs);

/// Up to `longest` (m) or four edges.
void close_holes(Mesh& mesh, double longest, MeshRepairs& repairs);

/// Connected over edges.
struct Shells {
  std::vector<int> of_triangle;
  // m³, signed; open shells as if closed to their first point.
  std::vector<double> volume;
  // shells around each; 0 above kMostNested
  std::vector<int> depth;
};
// more are probably fragments
inline constexpr std::size_t kMostNested = 200;
/// `nesting`: with depth.
Shells shells_of(const Mesh& mesh, bool nesting);

/// Even depth outward, odd (hollows) inward.
void turn_shells(Mesh& mesh, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
