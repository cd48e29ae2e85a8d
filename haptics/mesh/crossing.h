// Tests whether triangles cross each other. Touching does not count.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "haptics/mesh/editable_mesh.h"

namespace typodont::haptics::mesh {

/// Corners of a triangle, which need not be a face of the mesh.
struct Corners {
  Index v[3];
  dvec3 p[3];
};
/// Corners that two faces share: their number, and the index in each face of the last one.
struct SharedCorners {
  int count = 0, of_a = 0, of_b = 0;
  SharedCorners(const Corners& a, const Corners& b) noexcept {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (a.v[i] == b.v[j]) ++count, of_a = i, of_b = j;
      }
    }
  }
};
inline Corners corners(const EditableMesh& mesh, Index f) {
  const Face& face = mesh.face(f);
  return {{face.v[0], face.v[1], face.v[2]}, {mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2)}};
}

/// Crossing at a common vertex does not count; triangles with a common edge never cross.
bool cross_each_other(const Corners& a, const Corners& b) noexcept;

/// A table of triangles that quickly finds which of them may cross a given triangle. Only the constructor allocates.
class TriangleTable {
 public:
  explicit TriangleTable(std::size_t room = 0) : entries_(room) {}

  std::size_t room() const noexcept { return entries_.size(); }
  /// Stores the triangle i of the table.
  void set(std::size_t i, const dvec3& a, const dvec3& b, const dvec3& c) noexcept;
  /// Removes from `at` the triangles that certainly do not cross t; the order remains. Returns how many remain.
  std::size_t keep_possible(const Corners& t, std::uint32_t* at, std::size_t count) const noexcept;

  struct Entry {
    dvec3 lo, hi;  // m, bounding box
    dvec3 p[3];    // m, corners
  };

 private:
  std::vector<Entry> entries_;
};

/// Triangles with their bounding boxes, for crosses_any().
class BoxedTriangles {
 public:
  void add(const Corners& t) noexcept {
    Boxed& next = triangles_[count_++];
    next.t = t;
    next.lo = glm::min(glm::min(t.p[0], t.p[1]), t.p[2]), next.hi = glm::max(glm::max(t.p[0], t.p[1]), t.p[2]);
    next.lo_f = glm::vec3(next.lo), next.hi_f = glm::vec3(next.hi);
    lo_ = glm::min(lo_, next.lo), hi_ = glm::max(hi_, next.hi);
  }
  /// Corners of the box around all triangles, m.
  const dvec3& lo() const noexcept { return lo_; }
  const dvec3& hi() const noexcept { return hi_; }
  /// Returns true if face g crosses one of the triangles.
  bool crossed_by(const EditableMesh& mesh, Index g) const noexcept {
    const dvec3 &a = mesh.point(g, 0), &b = mesh.point(g, 1), &c = mesh.point(g, 2);
    const dvec3 lo = glm::min(glm::min(a, b), c), hi = glm::max(glm::max(a, b), c);
    for (std::size_t i = 0; i < count_; ++i) {
      const Boxed& boxed = triangles_[i];
      const bool apart = (hi.x < boxed.lo.x) | (hi.y < boxed.lo.y) | (hi.z < boxed.lo.z) | (lo.x > boxed.hi.x) |
                         (lo.y > boxed.hi.y) | (lo.z > boxed.hi.z);
      if (!apart && mesh.may_meet(g, boxed.lo_f, boxed.hi_f) && cross_each_other(boxed.t, corners(mesh, g)))
        return true;
    }
    return false;
  }

 private:
  struct Boxed {
    dvec3 lo, hi;          // m, corners of the bounding box
    glm::vec3 lo_f, hi_f;  // bounding box as floats
    Corners t;
  };
  std::array<Boxed, EditableMesh::kMaxAround> triangles_;
  std::size_t count_ = 0;
  dvec3 lo_{std::numeric_limits<double>::max()}, hi_{std::numeric_limits<double>::lowest()};
};

/// Returns true if a face for which counts(face) is true crosses one of the triangles, which must be near each other.
template <class Counts>
bool crosses_any(const EditableMesh& mesh, const BoxedTriangles& triangles, Counts&& counts) {
  bool found = false;
  mesh.near(triangles.lo(), triangles.hi(),
            [&](Index g) { found = found || (counts(g) && triangles.crossed_by(mesh, g)); });
  return found;
}

}  // namespace typodont::haptics::mesh
