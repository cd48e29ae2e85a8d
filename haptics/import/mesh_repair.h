// Repairs of triangle meshes: copies, orientation, holes, shells.
#pragma once

#include <vector>

#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

/// Leaves out triangles that have the same corners in the same order as an earlier one.
void drop_copies(Mesh& mesh, MeshRepairs& repairs);

/// Turns triangles so that neighbours across an edge of two triangles run along it in opposite directions. Of each
/// connected part the fewer are turned.
void orient(Mesh& mesh, MeshRepairs& repairs);

/// A walk along border edges (edges of an odd number of triangles), in the direction of their triangles.
struct Border {
  std::vector<int> points;
  double length = 0;   // m
  bool closed = true;  // false: its end is not its beginning; the triangles around it disagree about their direction
};
std::vector<Border> borders(const Mesh& mesh);

/// Closes one closed border by triangles around its middle.
void close_border(Mesh& mesh, const Border& border);

/// Closes borders at most `longest` long, and those of at most four edges.
void close_holes(Mesh& mesh, double longest, MeshRepairs& repairs);

/// Parts of a mesh that hang together over edges.
struct Shells {
  std::vector<int> of_triangle;
  std::vector<double> volume;  // of each shell, m³, signed; of an open one as closed towards its first point
  std::vector<int> depth;      // in how many other shells it lies wholly; 0 where there are more than kMostNested
};
inline constexpr std::size_t kMostNested = 200;  // shells; where there are more they are fragments
/// The depths are worked out only where `nesting` is asked for.
Shells shells_of(const Mesh& mesh, bool nesting);

/// Turns the shells: those in no other one, or in two, outwards; those in one or three inwards (they are hollows).
void turn_shells(Mesh& mesh, MeshRepairs& repairs);

}  // namespace typodont::haptics::importing
