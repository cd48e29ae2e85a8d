// Repairs triangle meshes: removes duplicate triangles, orients triangles and shells, closes holes.
#pragma once

#include <vector>

#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

/// Removes triangles that have the same corners in the same order as another one.
void drop_copies(Mesh& mesh, MeshRepairs& repairs);

/// Reverses triangles until neighbours list their common edge in opposite directions, with the fewest reversals in each
/// piece.
void orient(Mesh& mesh, MeshRepairs& repairs);

/// Border of a surface: a path along edges with an odd number of triangles, in the direction used by these triangles.
struct Border {
  std::vector<int> points;
  double length = 0;   // m, length of the border
  bool closed = true;  // false: the path does not close, because triangles are inconsistent
};
std::vector<Border> borders(const Mesh& mesh);

/// Closes a border with a fan of triangles around its centre. Adds repaired positions, but counts no hole.
void close_border(Mesh& mesh, const Border& border, MeshRepairs& repairs);

/// Closes holes whose border is at most `longest` (m) long or has at most four edges.
void close_holes(Mesh& mesh, double longest, MeshRepairs& repairs);

/// Shells: groups of triangles that are connected over edges.
struct Shells {
  std::vector<int> of_triangle;
  // Signed volume of each shell, m³. An open shell is closed by triangles from its border to its first point.
  std::vector<double> volume;
  // Number of shells around each shell; 0 if there are more than kMaxNested shells.
  std::vector<int> depth;
};
// More shells than this are probably fragments.
inline constexpr std::size_t kMaxNested = 200;
/// `nesting`: also computes Shells::depth.
Shells shells_of(const Mesh& mesh, bool nesting);

/// Makes shells inside an even number of other shells face outward, and shells inside an odd number (hollows) inward.
void turn_shells(Mesh& mesh, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
