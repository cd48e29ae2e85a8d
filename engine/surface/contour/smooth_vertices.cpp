#include "engine/surface/contour/smooth_vertices.h"

#include "engine/base/dispatch.h"
#include "engine/surface/contour/eight.h"

namespace typodont::surface {
namespace {

// A flat facet of side s is up to s²κ/4 below a surface of curvature κ, so vertices are raised by kLift·s²κ. A move by
// kCentre of the way to the cell's middle makes facets more regular. Measured in tests/property/surface_mesh_test.cpp.
constexpr float kCentre = 0.6f;
constexpr float kLift = 0.145f;
// largest distance of a vertex outside the surface, as a fraction of the block's side
constexpr float kMaxLift = 0.1f;
constexpr float kShortest = 1e-6f;  // length below which a mean normal has no direction

// Coordinates of one or eight points.
template <class Real>
struct Coordinates {
  Real x, y, z;
};
template <class Real>
TYPODONT_INLINE Real dot(const Coordinates<Real>& p, const Coordinates<Real>& q) {
  return p.x * q.x + p.y * q.y + p.z * q.z;
}

// Sums over the points where the surface crosses the edges of a cell (CrossingSums), for one or eight cells.
template <class Real>
struct Sums {
  Coordinates<Real> points, normals, by_normals;
  Real curvatures, count;
};

TYPODONT_INLINE Sums<float> sums_of(const CrossingSums& s) {
  return {{s.low[0], s.low[1], s.low[2]},
          {s.low[3], s.high[0], s.high[1]},
          {s.by_normals[0], s.by_normals[1], s.by_normals[2]},
          s.high[2],
          s.high[3]};
}
TYPODONT_INLINE Eight lane_of(const CrossingSums* const s[8], Four CrossingSums::*vector, int lane) {
  return Eight{(s[0]->*vector)[lane], (s[1]->*vector)[lane], (s[2]->*vector)[lane], (s[3]->*vector)[lane],
               (s[4]->*vector)[lane], (s[5]->*vector)[lane], (s[6]->*vector)[lane], (s[7]->*vector)[lane]};
}
TYPODONT_INLINE Sums<Eight> sums_of(const CrossingSums* const s[8]) {
  constexpr auto low = &CrossingSums::low, high = &CrossingSums::high, by_normals = &CrossingSums::by_normals;
  return {{lane_of(s, low, 0), lane_of(s, low, 1), lane_of(s, low, 2)},
          {lane_of(s, low, 3), lane_of(s, high, 0), lane_of(s, high, 1)},
          {lane_of(s, by_normals, 0), lane_of(s, by_normals, 1), lane_of(s, by_normals, 2)},
          lane_of(s, high, 2),
          lane_of(s, high, 3)};
}

template <class Real>
TYPODONT_INLINE Coordinates<Real> vertex_of(const Sums<Real>& sums, float s) {
  const Real w = 1 / sums.count;
  const Coordinates<Real> x{sums.points.x * w, sums.points.y * w, sums.points.z * w};
  const Coordinates<Real> n{sums.normals.x * w, sums.normals.y * w, sums.normals.z * w};
  const Real length = root(dot(n, n));
  const Coordinates<Real> unit{n.x / length, n.y / length, n.z / length};
  const Real curvature = sums.curvatures * w;
  const Real points_by_normals = sums.by_normals.x + sums.by_normals.y + sums.by_normals.z;
  const Real onto_surface = limited(0.5f * (points_by_normals * w - dot(x, n)), -0.5f * s, 0.5f * s);
  const Real height = dot(x, unit);
  const Coordinates<Real> along{-kCentre * (x.x - unit.x * height), -kCentre * (x.y - unit.y * height),
                                -kCentre * (x.z - unit.z * height)};
  const Real stay_on_surface = -0.5f * curvature * dot(along, along);
  const Real lift = limited(kLift * s * s * curvature, -kMaxLift * s, kMaxLift * s);
  const Real outwards = onto_surface + stay_on_surface + lift;
  const auto no_normal = length < kShortest;
  return {no_normal ? x.x : x.x + along.x + unit.x * outwards, no_normal ? x.y : x.y + along.y + unit.y * outwards,
          no_normal ? x.z : x.z + along.z + unit.z * outwards};
}

template <class Real>
TYPODONT_INLINE Coordinates<Real> normal_of(const Sums<Real>& sums) {
  const Real length = root(dot(sums.normals, sums.normals)), zero{}, one = zero + 1;
  const auto has_normal = length > kShortest;
  return {has_normal ? sums.normals.x / length : zero, has_normal ? sums.normals.y / length : zero,
          has_normal ? sums.normals.z / length : one};
}

TYPODONT_INLINE void write(const Coordinates<Eight>& from, float to[3][8]) {
  for (int i = 0; i < 8; ++i) to[0][i] = from.x[i], to[1][i] = from.y[i], to[2][i] = from.z[i];
}

}  // namespace

glm::vec3 smooth_vertex(const CrossingSums& sums, float s) {
  const Coordinates<float> vertex = vertex_of(sums_of(sums), s);
  return {vertex.x, vertex.y, vertex.z};
}

glm::vec3 unit_normal(const CrossingSums& sums) {
  const Coordinates<float> normal = normal_of(sums_of(sums));
  return {normal.x, normal.y, normal.z};
}

TYPODONT_DISPATCH("avx2", "default")
void smooth_vertices(const CrossingSums* const sums[8], SmoothVertices& out) {
  const Sums<Eight> eight = sums_of(sums);
  write(vertex_of(eight, 1.f), out.position);
  write(normal_of(eight), out.normal);
}

TYPODONT_DISPATCH("avx2", "default")
unsigned spread_of_normals(const CrossingSums* const sums[8], float limit) {
  const Sums<Eight> eight = sums_of(sums);
  const Coordinates<Eight> mean{eight.normals.x / eight.count, eight.normals.y / eight.count,
                                eight.normals.z / eight.count};
  return bits_of(~(1 - dot(mean, mean) < limit));
}

}  // namespace typodont::surface
