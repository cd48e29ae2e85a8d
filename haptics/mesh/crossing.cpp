#include "haptics/mesh/crossing.h"

#include <bit>
#include <cmath>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::mesh {

namespace {

/// Six times the volume of the tetrahedron a, b, c, d; positive if a, b, c is clockwise seen from d.
double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
  return glm::dot(a - d, glm::cross(b - d, c - d));
}

/// True if the segment passes through the triangle a, b, c. `s`, `e`: volume6(a, b, c, from or to); their signs differ.
bool passes_between(const dvec3& from, const dvec3& to, double s, double e, const dvec3& a, const dvec3& b,
                    const dvec3& c) noexcept {
  constexpr double kTouches = 1e-12;  // m; points nearer to a plane count as lying in it
  const double in_plane = kTouches * glm::length(glm::cross(b - a, c - a));
  if (std::abs(s) < in_plane || std::abs(e) < in_plane) return false;
  const double ab = volume6(from, to, a, b), bc = volume6(from, to, b, c), ca = volume6(from, to, c, a);
  return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
}

/// Returns true if all corners of `from` are clearly on one side of the plane of t.
bool is_beside(const Corners& from, const Corners& t) noexcept {
  // m; at a larger distance from the plane, rounding cannot change the side
  constexpr double kClear = 1e-10;
  const dvec3 n = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
  const double clear = kClear * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  const double a = glm::dot(n, from.p[0] - t.p[0]), b = glm::dot(n, from.p[1] - t.p[0]),
               c = glm::dot(n, from.p[2] - t.p[0]);
  return (a > clear && b > clear && c > clear) || (a < -clear && b < -clear && c < -clear);
}

constexpr std::size_t kBatch = 8;
// m; triangles whose boxes are farther apart than this certainly do not cross
constexpr double kApart = 1e-9;

/// Corners of eight triangles, one per lane, or of the same triangle in all lanes.
struct Eight {
  D8 p[3][3];
};

/// volume6() of triangles t with corner i of `from`.
TYPODONT_INLINE void volumes(const Eight& from, int i, const Eight& t, D8& v) {
  D8 a[3], b[3], c[3];
  for (int k = 0; k < 3; ++k) {
    a[k] = t.p[0][k] - from.p[i][k], b[k] = t.p[1][k] - from.p[i][k], c[k] = t.p[2][k] - from.p[i][k];
  }
  v = a[0] * (b[1] * c[2] - c[1] * b[2]) + a[1] * (b[2] * c[0] - c[2] * b[0]) + a[2] * (b[0] * c[1] - c[0] * b[1]);
}

/// Sets each lane of `some` in which an edge of `from` leads from one side of t's plane to the other side.
TYPODONT_INLINE void edges_between_sides(const Eight& from, const Eight& t, L8& some) {
  D8 v[3];
  for (int i = 0; i < 3; ++i) volumes(from, i, t, v[i]);
  some |= (v[0] * v[1] < 0.0) | (v[1] * v[2] < 0.0) | (v[2] * v[0] < 0.0);
}

/// Keeps the triangles in `at` that cross t's plane with an edge, or whose plane t crosses. Returns their number.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t keep_straddling(const TriangleTable::Entry* entries, const dvec3* t, std::uint32_t* at, std::size_t count) {
  std::size_t kept = 0;
  Eight one, many;
  double columns[3][3][kBatch];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) one.p[i][k] = D8{} + t[i][k];
  for (std::size_t first = 0; first < count; first += kBatch) {
    const std::size_t end = count - first < kBatch ? count - first : kBatch;
    for (std::size_t lane = 0; lane < kBatch; ++lane) {
      const TriangleTable::Entry& entry = entries[at[first + (lane < end ? lane : 0)]];
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) columns[i][k][lane] = entry.p[i][k];
    }
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) read_lanes(many.p[i][k], columns[i][k]);
    L8 some = {};
    edges_between_sides(one, many, some);
    edges_between_sides(many, one, some);
    const unsigned lanes = (1u << end) - 1;
    for (unsigned bits = bits_of(some) & lanes; bits; bits &= bits - 1) {
      at[kept++] = at[first + static_cast<std::size_t>(std::countr_zero(bits))];
    }
  }
  return kept;
}

}  // namespace

void TriangleTable::set(std::size_t i, const dvec3& a, const dvec3& b, const dvec3& c) noexcept {
  entries_[i] = {glm::min(glm::min(a, b), c) - kApart, glm::max(glm::max(a, b), c) + kApart, {a, b, c}};
}

std::size_t TriangleTable::keep_possible(const Corners& t, std::uint32_t* at, std::size_t count) const noexcept {
  const dvec3 lo = glm::min(glm::min(t.p[0], t.p[1]), t.p[2]), hi = glm::max(glm::max(t.p[0], t.p[1]), t.p[2]);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Entry& entry = entries_[at[i]];
    const bool apart = (entry.lo.x > hi.x) | (entry.lo.y > hi.y) | (entry.lo.z > hi.z) | (entry.hi.x < lo.x) |
                       (entry.hi.y < lo.y) | (entry.hi.z < lo.z);
    at[kept] = at[i];
    kept += !apart;
  }
  return keep_straddling(entries_.data(), t.p, at, kept);
}

bool cross_each_other(const Corners& a, const Corners& b) noexcept {
  const SharedCorners shared(a, b);
  if (shared.count >= 2 || is_beside(a, b) || is_beside(b, a)) return false;
  // Computes the signed volume of triangle t and a corner once for both edges that meet at this corner.
  const auto volumes = [](const Corners& from, const Corners& t, double(&v)[3]) {
    for (int i = 0; i < 3; ++i) v[i] = volume6(t.p[0], t.p[1], t.p[2], from.p[i]);
  };
  double in_a[3], in_b[3];
  volumes(a, b, in_a), volumes(b, a, in_b);
  const auto edge = [](const Corners& from, int i, const double(&v)[3], const Corners& t) {
    const int k = (i + 1) % 3;
    return v[i] * v[k] < 0 && passes_between(from.p[i], from.p[k], v[i], v[k], t.p[0], t.p[1], t.p[2]);
  };
  if (shared.count == 1) return edge(a, (shared.of_a + 1) % 3, in_a, b) || edge(b, (shared.of_b + 1) % 3, in_b, a);
  for (int i = 0; i < 3; ++i) {
    if (edge(a, i, in_a, b) || edge(b, i, in_b, a)) return true;
  }
  return false;
}

}  // namespace typodont::haptics::mesh
