// Tests whether triangles cross each other. Triangles that only touch do not cross.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptics/mesh/editable_mesh.h"

namespace typodont::haptics::mesh {

/// A triangle with the indices of its vertices. It need not be a face of the mesh.
struct Corners {
  Index v[3];
  dvec3 p[3];
};
inline Corners corners(const EditableMesh& mesh, Index f) {
  const Face& face = mesh.face(f);
  return {{face.v[0], face.v[1], face.v[2]}, {mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2)}};
}

/// Returns true if a point of the segment `from`–`to`, except its ends, lies in the interior of the triangle a, b, c.
bool passes_through(const dvec3& from, const dvec3& to, const dvec3& a, const dvec3& b, const dvec3& c) noexcept;

/// Returns true if two triangles cross each other. A common vertex does not count as a crossing, and triangles with a
/// common edge never cross each other.
bool cross_each_other(const Corners& a, const Corners& b) noexcept;

/// A table of triangles. It quickly finds those of its triangles that cannot cross a given triangle. Allocates memory
/// only in the constructor.
class TriangleTable {
 public:
  explicit TriangleTable(std::size_t room = 0) : entries_(room) {}

  std::size_t room() const noexcept { return entries_.size(); }
  /// Stores the triangle i of the table.
  void set(std::size_t i, const dvec3& a, const dvec3& b, const dvec3& c) noexcept;
  /// The list `at` has the indices of `count` triangles. Removes triangles from this list that certainly do not cross
  /// t, and keeps the order of the others. A triangle that is kept may cross t or not. Returns the number of kept
  /// triangles.
  std::size_t keep_possible(const Corners& t, std::uint32_t* at, std::size_t count) const noexcept;

  struct Entry {
    dvec3 lo, hi;  // m, bounding box
    dvec3 p[3];    // m, corners
  };

 private:
  std::vector<Entry> entries_;
};

/// Returns the first face of the mesh that crosses a triangle, or kNone. Only faces for which counts(face) is true are
/// tested.
template <class Counts>
Index crossed_by(const EditableMesh& mesh, const Corners& t, Counts&& counts) {
  const dvec3 lo = glm::min(glm::min(t.p[0], t.p[1]), t.p[2]), hi = glm::max(glm::max(t.p[0], t.p[1]), t.p[2]);
  Index found = kNone;
  mesh.near(lo, hi, [&](Index g) {
    if (found != kNone || !counts(g)) return;
    const Corners other = corners(mesh, g);
    for (int axis = 0; axis < 3; ++axis) {
      const double a = other.p[0][axis], b = other.p[1][axis], c = other.p[2][axis];
      if ((a < lo[axis] && b < lo[axis] && c < lo[axis]) || (a > hi[axis] && b > hi[axis] && c > hi[axis])) return;
    }
    if (cross_each_other(t, other)) found = g;
  });
  return found;
}

}  // namespace typodont::haptics::mesh
