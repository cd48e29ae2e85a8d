// Repairs triangle meshes: removes duplicate faces, orients faces, closes holes, separates shells.
#pragma once

#include <vector>

#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

/// Removes triangles with the same corners in the same order as an earlier triangle.
void drop_copies(Mesh& mesh, MeshRepairs& repairs);

/// Reverses triangles so that two neighbours run along their common edge in opposite directions. In each connected
/// part, the smaller number of triangles is reversed.
void orient(Mesh& mesh, MeshRepairs& repairs);

/// A path along border edges (edges with an odd number of triangles), in the direction of their triangles.
struct Border {
  std::vector<int> points;
  double length = 0;   // m
  bool closed = true;  // false: the path is not a loop, because the triangles around it have inconsistent directions
};
std::vector<Border> borders(const Mesh& mesh);

/// Closes one closed border by triangles around its centre.
void close_border(Mesh& mesh, const Border& border);

/// Closes all borders with a length of at most `longest` (m) or at most four edges.
void close_holes(Mesh& mesh, double longest, MeshRepairs& repairs);

/// Parts of a mesh that are connected over edges.
struct Shells {
  std::vector<int> of_triangle;
  // m³, signed volume of each shell; an open shell is closed at its first point to compute its volume
  std::vector<double> volume;
  // Number of other shells that contain this shell completely; 0 if there are more than kMostNested shells
  std::vector<int> depth;
};
inline constexpr std::size_t kMostNested = 200;  // limit of the number of shells; more shells count as fragments
/// `nesting`: also compute the depths.
Shells shells_of(const Mesh& mesh, bool nesting);

/// Orients the shells. A shell inside an even number of other shells (or none) is made to face outward; all other
/// shells are hollows and are made to face inward.
void turn_shells(Mesh& mesh, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
