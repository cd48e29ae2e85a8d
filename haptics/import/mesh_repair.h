// Repairs triangle meshes: removes copies of triangles, orients triangles, closes holes, separates shells.
#pragma once

#include <vector>

#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

/// Removes each triangle that has the same corners in the same order as an earlier triangle.
void drop_copies(Mesh& mesh, MeshRepairs& repairs);

/// Orients the triangles so that two neighbours list their common edge in opposite directions. In each connected piece
/// of the mesh, the function reverses as few triangles as possible.
void orient(Mesh& mesh, MeshRepairs& repairs);

/// A border of a mesh: a path along edges that have an odd number of triangles. The path runs in the direction in which
/// these triangles list the edges.
struct Border {
  std::vector<int> points;
  double length = 0;   // m, length of the border
  bool closed = true;  // false if the path is no loop, because the triangles along it have inconsistent directions
};
std::vector<Border> borders(const Mesh& mesh);

/// Closes a hole whose border is a closed loop, with triangles around the border's centre. Adds their places to
/// `repairs`, but does not count the hole.
void close_border(Mesh& mesh, const Border& border, MeshRepairs& repairs);

/// Closes all holes whose border is at most `longest` (m) long or has at most four edges.
void close_holes(Mesh& mesh, double longest, MeshRepairs& repairs);

/// The shells of a mesh. A shell is a piece of the mesh whose triangles are connected over edges.
struct Shells {
  std::vector<int> of_triangle;
  // Signed volume of each shell in m³. For an open shell, the volume is computed as if triangles from its border to its
  // first point closed it.
  std::vector<double> volume;
  // For each shell: number of other shells that contain it completely. If there are more than kMostNested shells, it is
  // 0 for every shell, because it is not computed.
  std::vector<int> depth;
};
// largest number of shells for which Shells::depth is computed; if a mesh has more shells, they are probably fragments
inline constexpr std::size_t kMostNested = 200;
/// Finds the shells of a mesh. With `nesting`, it also computes Shells::depth.
Shells shells_of(const Mesh& mesh, bool nesting);

/// Orients the shells. The triangles of a shell face outward if it lies inside no other shell, or inside an even number
/// of other shells. All other shells are the surfaces of hollows, and their triangles face inward.
void turn_shells(Mesh& mesh, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
