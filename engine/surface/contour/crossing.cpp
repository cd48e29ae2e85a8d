#include "engine/surface/contour/crossing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "engine/base/dispatch.h"
#include "engine/surface/contour/eight.h"

namespace typodont::surface {
namespace {

// Both ends of an edge count as on one plane if |gradient|² differs from 1 by less than kUnit at each end, and the
// gradients' two components across the edge differ by less than kSame (root mean square).
constexpr float kUnit = 2e-6f;
constexpr float kSame = 3e-3f;
// voxels; a second difference above this at the end of an edge shows a crease nearby, or a radius below four voxels
constexpr float kBent = 0.25f;
// smallest jump of the field's slope along an edge that shows a crease; curvature causes smaller jumps
constexpr float kSlopeJump = 0.6f;
// difference of |gradient|² from 1 that shows that the samples lie on both sides of a crease
constexpr float kAcross = 0.05f;

// Gradient at an end of one edge or of eight edges: `a` along, `b` and `c` across the edge; `excess`: |length² − 1|.
template <class Real>
struct Gradient {
  Real a, b, c, excess;
};

template <class Real>
TYPODONT_INLINE Gradient<Real> gradient(Real a, Real b, Real c) {
  return {a, b, c, absolute(a * a - 1 + b * b + c * c)};
}

template <class Mask, class Real>
TYPODONT_INLINE void take_if(Mask condition, const Gradient<Real>& other, Gradient<Real>& g) {
  g.a = condition ? other.a : g.a, g.b = condition ? other.b : g.b, g.c = condition ? other.c : g.c;
  g.excess = condition ? other.excess : g.excess;
}

// Four gradients at an end of an edge, by one-sided differences. On each of the two axes across the edge, a gradient
// uses the lower or the upper neighbour.
template <class Real>
struct OneSided {
  Gradient<Real> pair[4];

  TYPODONT_INLINE OneSided(Real f, Real slope, Real lower_b, Real upper_b, Real lower_c, Real upper_c) {
    const Real b[2] = {upper_b - f, f - lower_b}, c[2] = {upper_c - f, f - lower_c};
    for (int i = 0; i < 4; ++i) pair[i] = gradient(slope, b[i & 1], c[i >> 1]);
  }
  TYPODONT_INLINE auto unit() const {
    return (pair[0].excess < kUnit) | (pair[1].excess < kUnit) | (pair[2].excess < kUnit) | (pair[3].excess < kUnit);
  }
  TYPODONT_INLINE Gradient<Real> best() const {
    Gradient<Real> best = pair[0];
    for (int i = 1; i < 4; ++i) take_if(pair[i].excess < best.excess, pair[i], best);
    return best;
  }
};

OneSided<float> one_sided(const float* at, float slope, int b, int c) {
  return {*at, slope, at[-b], at[b], at[-c], at[c]};
}

struct NearCrease {
  float t;  // 0..1, position of the crossing along the grid edge
  Gradient<float> gradient;
};

// Returns the crossing of an edge near a crease, or nothing if there is no crease. `at`: sample at the edge's start; a:
// stride along the edge; b, c: strides across it.
std::optional<NearCrease> cross_near_crease(const float* at, int a, int b, int c) {
  const float* end = at + a;
  const float before = at[-a], f0 = at[0], f1 = end[0], after = end[a];
  const float bend0 = before - 2 * f0 + f1, bend1 = f0 - 2 * f1 + after;
  // At a crease, the field is the maximum or minimum of two planes' distances. The samples before the edge belong to
  // one plane, those after it to the other.
  const float slope0 = f0 - before, slope1 = after - f1;
  const float t0 = slope0 != 0 ? -f0 / slope0 : -1.f, t1 = slope1 != 0 ? 1 - f1 / slope1 : -1.f;
  const bool in0 = t0 >= 0 && t0 <= 1, in1 = t1 >= 0 && t1 <= 1;
  const float jump = bend0 + bend1;
  if (bend0 * bend1 > 0 && (in0 || in1)) {
    const bool first = in0 && (!in1 || ((jump > 0) == (f0 < 0) ? t0 <= t1 : t0 > t1));
    const OneSided<float> side = first ? one_sided(at, slope0, b, c) : one_sided(end, slope1, b, c);
    if (side.unit() || std::abs(jump) > kSlopeJump) return NearCrease{first ? t0 : t1, side.best()};
  }
  // If the crease passes beside the edge, uses the one-sided gradient (at either end) whose length is nearest to 1.
  const OneSided<float> here = one_sided(at, f1 - f0, b, c), there = one_sided(end, f1 - f0, b, c);
  if (!here.unit() && !there.unit()) return std::nullopt;
  const Gradient<float> p = here.best(), q = there.best();
  return NearCrease{f0 / (f0 - f1), p.excess < q.excess ? p : q};
}

constexpr unsigned kAllLanes = 0xff;

// `t`: position of the crossing along the edge, 0..1. Normal: component `na` along the edge, `nb` and `nc` across it.
struct EightCrossings {
  Eight t, na, nb, nc, curvature;
};

// Returns which edges have both ends on the same plane, and sets the gradients of these planes in `out`.
TYPODONT_INLINE EightInts same_planes(const OneSided<Eight>& p, const OneSided<Eight>& q, Gradient<Eight>& out) {
  Eight least = Eight{} + 2 * kSame * kSame;
  EightInts found{};
  for (int i = 0; i < 4; ++i) {
    const Gradient<Eight>& g = p.pair[i];
    for (int j = 0; j < 4; ++j) {
      const Gradient<Eight>& h = q.pair[j];
      const Eight off = (g.b - h.b) * (g.b - h.b) + (g.c - h.c) * (g.c - h.c);
      const EightInts take = (g.excess < kUnit) & (h.excess < kUnit) & (off < least);
      least = take ? off : least;
      take_if(take, g, out);
      found |= take;
    }
  }
  return found;
}

// `at`: samples at the edges' starts. Strides: a along the edges, b and c across. Along each edge, reads the samples
// from -a to 2a; across, reads the neighbours ±b and ±c of both ends.
TYPODONT_INLINE EightCrossings cross_eight(const float* const at[8], int a, int b, int c) {
  const auto load = [at](int offset) __attribute__((always_inline)) {
    return Eight{at[0][offset], at[1][offset], at[2][offset], at[3][offset],
                 at[4][offset], at[5][offset], at[6][offset], at[7][offset]};
  };
  const Eight before = load(-a), f0 = load(0), f1 = load(a), after = load(2 * a);
  const Eight lower_b0 = load(-b), upper_b0 = load(b), lower_c0 = load(-c), upper_c0 = load(c);
  const Eight lower_b1 = load(a - b), upper_b1 = load(a + b), lower_c1 = load(a - c), upper_c1 = load(a + c);
  const Eight slope = f1 - f0;
  const Eight bend0 = before - 2 * f0 + f1, bend1 = f0 - 2 * f1 + after;
  const Eight b0 = upper_b0 + lower_b0 - 2 * f0, c0 = upper_c0 + lower_c0 - 2 * f0;
  const Eight b1 = upper_b1 + lower_b1 - 2 * f1, c1 = upper_c1 + lower_c1 - 2 * f1;
  const OneSided<Eight> here(f0, slope, lower_b0, upper_b0, lower_c0, upper_c0);
  const OneSided<Eight> there(f1, slope, lower_b1, upper_b1, lower_c1, upper_c1);
  const EightInts bent = (absolute(bend0) > kBent) | (absolute(bend1) > kBent) | (absolute(b0) > kBent) |
                         (absolute(c0) > kBent) | (absolute(b1) > kBent) | (absolute(c1) > kBent);

  const Eight zero{};
  const Eight straight = f0 / (f0 - f1);
  Eight t = straight, curvature = zero;
  Gradient<Eight> g, plane{};
  EightInts flat{};
  if (const EightInts unit = here.unit() & there.unit(); bits_of(unit) != 0) flat = same_planes(here, there, plane);
  if (bits_of(flat) != kAllLanes) {
    const Eight smaller_bend = bend0 * bend1 <= 0 ? zero : absolute(bend0) < absolute(bend1) ? bend0 : bend1;
    const Eight bend = absolute(bend0 + bend1) > kSlopeJump ? zero : smaller_bend;
    const Eight steep = slope - 0.5f * bend * (1 - 2 * t);
    t = absolute(steep) > 0.1f ? limited(t + 0.5f * bend * t * (1 - t) / steep, 0.f, 1.f) : t;
    g = gradient(slope - 0.5f * bend * (1 - 2 * t),
                 0.5f * ((1 - t) * (upper_b0 - lower_b0) + t * (upper_b1 - lower_b1)),
                 0.5f * ((1 - t) * (upper_c0 - lower_c0) + t * (upper_c1 - lower_c1)));
    // The mean curvature is half the Laplacian of the field.
    curvature = 0.5f * (bend + (1 - t) * (b0 + c0) + t * (b1 + c1));
    if (const EightInts across = g.excess > kAcross; bits_of(across) != 0) {
      Gradient<Eight> better = there.best();
      const Gradient<Eight> best_here = here.best();
      take_if(best_here.excess < better.excess, best_here, better);
      const EightInts take = across & (3 * better.excess < g.excess);
      take_if(take, better, g);
      curvature = take ? zero : curvature;
    }
    take_if(flat, plane, g);
    t = flat ? straight : t;
    curvature = flat ? zero : curvature;
  } else {
    g = plane;
  }
  for (unsigned near = bits_of(bent & ~flat); near; near &= near - 1) {
    const int i = std::countr_zero(near);
    const std::optional<NearCrease> one = cross_near_crease(at[i], a, b, c);
    if (!one) continue;
    t[i] = one->t, curvature[i] = 0;
    g.a[i] = one->gradient.a, g.b[i] = one->gradient.b, g.c[i] = one->gradient.c;
  }
  const Eight length = root(g.a * g.a + g.b * g.b + g.c * g.c), along = slope > 0 ? zero + 1 : zero - 1;
  const EightInts has_normal = length > 1e-6f;
  return {t, has_normal ? g.a / length : along, has_normal ? g.b / length : zero, has_normal ? g.c / length : zero,
          has_normal ? curvature : zero};
}

}  // namespace

TYPODONT_DISPATCH("avx2", "default")
void cross_edges(const float* field, const int stride[3], int axis, std::span<const GridEdge> edges, Crossing* out) {
  const int b_axis = (axis + 1) % 3, c_axis = (axis + 2) % 3;
  for (std::size_t first = 0; first < edges.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, edges.size() - first);
    const float* at[8];
    for (std::size_t i = 0; i < 8; ++i) at[i] = field + edges[first + std::min(i, count - 1)].sample;
    const EightCrossings eight = cross_eight(at, stride[axis], stride[b_axis], stride[c_axis]);
    for (std::size_t i = 0; i < count; ++i) {
      const GridEdge& edge = edges[first + i];
      Crossing& crossing = out[first + i];
      crossing.point[0] = edge.x, crossing.point[1] = edge.y, crossing.point[2] = edge.z;
      crossing.point[axis] += eight.t[i];
      crossing.normal[axis] = eight.na[i], crossing.normal[b_axis] = eight.nb[i], crossing.normal[c_axis] = eight.nc[i];
      crossing.curvature = eight.curvature[i];
      crossing.one = 1;
    }
  }
}

}  // namespace typodont::surface
