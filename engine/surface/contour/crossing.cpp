#include "engine/surface/contour/crossing.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/base/dispatch.h"
#include "engine/surface/contour/eight.h"

namespace typodont::surface {
namespace {

// Limits for the test whether the samples at both ends of an edge lie on one plane. On a plane, the squared length of
// the field's gradient differs from 1 by less than kUnit (rounding), and each component of the gradient differs between
// the two ends by less than kSame. On a curved surface, both conditions are very rarely met.
constexpr float kUnit = 2e-6f;
constexpr float kSame = 3e-3f;
// Voxels, limit of the second differences of the field at the ends of the edge. If one of them is larger, there is a
// crease near the edge, or the surface has a radius of curvature of less than four voxels.
constexpr float kBent = 0.25f;
// The slope of the field before the edge is compared with its slope behind the edge, along the edge's line. If the
// slopes differ by more than this, the surface has a crease there, because curvature alone changes the slope less.
constexpr float kSlopeJump = 0.6f;
// In a distance field, the squared length of the gradient is 1. If the value from central differences deviates from 1
// by more than this, samples from both sides of a crease were used.
constexpr float kAcross = 0.05f;

float smaller(float p, float q) {
  return p * q <= 0 ? 0 : std::abs(p) < std::abs(q) ? p : q;
}

struct Gradient {
  float a = 0, b = 0, c = 0;
  float excess() const { return std::abs(a * a - 1 + b * b + c * c); }
};

// The four gradients that one-sided differences give at a sample. The component along the edge is given. For each of
// the two axes across the edge, there is one difference to the lower and one to the upper neighbour, so there are four
// combinations.
struct OneSided {
  float a, b[2], c[2];

  OneSided(const float* p, float slope, int stride_b, int stride_c)
      : a(slope), b{p[stride_b] - *p, *p - p[-stride_b]}, c{p[stride_c] - *p, *p - p[-stride_c]} {}

  Gradient pair(int i) const { return {a, b[i & 1], c[i >> 1]}; }
  bool unit() const {
    const float rest = a * a - 1, b0 = rest + b[0] * b[0], b1 = rest + b[1] * b[1];
    const float c0 = c[0] * c[0], c1 = c[1] * c[1];
    // Tests the four gradients without branches, because the processor would often predict the branches wrongly.
    return (static_cast<int>(std::abs(b0 + c0) < kUnit) | static_cast<int>(std::abs(b1 + c0) < kUnit) |
            static_cast<int>(std::abs(b0 + c1) < kUnit) | static_cast<int>(std::abs(b1 + c1) < kUnit)) != 0;
  }
  Gradient best() const {
    Gradient best = pair(0);
    for (int i = 1; i < 4; ++i) {
      if (pair(i).excess() < best.excess()) best = pair(i);
    }
    return best;
  }
};

// Returns true if the samples at both ends of the edge lie on the same plane; `out` is then the plane's gradient.
bool same_plane(const OneSided& p, const OneSided& q, Gradient& out) {
  if (!p.unit() || !q.unit()) return false;
  float least = 2 * kSame * kSame;
  bool found = false;
  for (int i = 0; i < 4; ++i) {
    const Gradient g = p.pair(i);
    if (g.excess() >= kUnit) continue;
    for (int j = 0; j < 4; ++j) {
      const Gradient h = q.pair(j);
      if (h.excess() >= kUnit) continue;
      const float off = (g.b - h.b) * (g.b - h.b) + (g.c - h.c) * (g.c - h.c);
      if (off >= least) continue;
      least = off;
      out = g;
      found = true;
    }
  }
  return found;
}

}  // namespace

LocalCrossing cross_edge(const float* at, int a, int b, int c) {
  const float* end = at + a;
  const float before = at[-a], f0 = at[0], f1 = end[0], after = end[a];
  const float slope = f1 - f0;
  const float bend0 = before - 2 * f0 + f1, bend1 = f0 - 2 * f1 + after;
  const float b0 = at[b] + at[-b] - 2 * f0, c0 = at[c] + at[-c] - 2 * f0;
  const float b1 = end[b] + end[-b] - 2 * f1, c1 = end[c] + end[-c] - 2 * f1;
  const float bent =
      std::max({std::abs(bend0), std::abs(bend1), std::abs(b0), std::abs(c0), std::abs(b1), std::abs(c1)});

  float t = f0 / (f0 - f1), curvature = 0;
  Gradient g;
  const OneSided here(at, slope, b, c), there(end, slope, b, c);
  bool solved = same_plane(here, there, g);
  if (!solved && bent > kBent) {
    // If the edge crosses a crease, the field is the maximum (convex) or minimum of the distances to two planes. The
    // samples before the edge belong to one plane, the samples after the edge to the other.
    const float slope0 = f0 - before, slope1 = after - f1;
    const float t0 = slope0 != 0 ? -f0 / slope0 : -1.f, t1 = slope1 != 0 ? 1 - f1 / slope1 : -1.f;
    const bool in0 = t0 >= 0 && t0 <= 1, in1 = t1 >= 0 && t1 <= 1;
    const float jump = bend0 + bend1;
    if (bend0 * bend1 > 0 && (in0 || in1)) {
      const bool first = in0 && (!in1 || ((jump > 0) == (f0 < 0) ? t0 <= t1 : t0 > t1));
      const OneSided side = first ? OneSided(at, slope0, b, c) : OneSided(end, slope1, b, c);
      if (side.unit() || std::abs(jump) > kSlopeJump) {
        t = first ? t0 : t1;
        g = side.best();
        solved = true;
      }
    }
    if (!solved && (here.unit() || there.unit())) {
      // A crease of the surface may run beside this edge of the grid. Then at least one of the gradients from one-sided
      // differences uses only samples on one side of the crease, and its length is 1. So the gradient whose length is
      // nearest to 1 is used.
      const Gradient p = here.best(), q = there.best();
      g = p.excess() < q.excess() ? p : q;
      solved = true;
    }
  }
  if (!solved) {
    const float bend = std::abs(bend0 + bend1) > kSlopeJump ? 0 : smaller(bend0, bend1);
    const float steep = slope - 0.5f * bend * (1 - 2 * t);
    if (std::abs(steep) > 0.1f) t = std::clamp(t + 0.5f * bend * t * (1 - t) / steep, 0.f, 1.f);
    g.a = slope - 0.5f * bend * (1 - 2 * t);
    g.b = 0.5f * ((1 - t) * (at[b] - at[-b]) + t * (end[b] - end[-b]));
    g.c = 0.5f * ((1 - t) * (at[c] - at[-c]) + t * (end[c] - end[-c]));
    // The mean curvature is half the Laplacian of the distance field, because the Laplacian is the sum of the two
    // principal curvatures.
    curvature = 0.5f * (bend + (1 - t) * (b0 + c0) + t * (b1 + c1));
    if (g.excess() > kAcross) {
      const Gradient p = here.best(), q = there.best();
      const Gradient better = p.excess() < q.excess() ? p : q;
      if (3 * better.excess() < g.excess()) {
        g = better;
        curvature = 0;
      }
    }
  }
  const float length = std::sqrt(g.a * g.a + g.b * g.b + g.c * g.c);
  if (!(length > 1e-6f)) return {t, slope > 0 ? 1.f : -1.f, 0, 0, 0};
  return {t, g.a / length, g.b / length, g.c / length, curvature};
}

namespace {

constexpr unsigned kAllLanes = 0xff;

// Gradients of eight edges, and by how much the squares of their lengths differ from 1 (Gradient::excess).
struct Gradients {
  Eight a, b, c, excess;
};

TYPODONT_INLINE Eight excess_of(Eight a, Eight b, Eight c) {
  return absolute(a * a - 1 + b * b + c * c);
}

TYPODONT_INLINE void take_if(EightInts condition, const Gradients& other, Gradients& g) {
  g.a = condition ? other.a : g.a, g.b = condition ? other.b : g.b, g.c = condition ? other.c : g.c;
  g.excess = condition ? other.excess : g.excess;
}

// The gradients of OneSided, for eight edges.
struct OneSidedGradients {
  Gradients pair[4];

  TYPODONT_INLINE OneSidedGradients(Eight f, Eight slope, Eight lower_b, Eight upper_b, Eight lower_c, Eight upper_c) {
    const Eight b[2] = {upper_b - f, f - lower_b}, c[2] = {upper_c - f, f - lower_c};
    for (int i = 0; i < 4; ++i) pair[i] = {slope, b[i & 1], c[i >> 1], excess_of(slope, b[i & 1], c[i >> 1])};
  }
  TYPODONT_INLINE EightInts unit() const {
    return (pair[0].excess < kUnit) | (pair[1].excess < kUnit) | (pair[2].excess < kUnit) | (pair[3].excess < kUnit);
  }
  TYPODONT_INLINE Gradients best() const {
    Gradients best = pair[0];
    for (int i = 1; i < 4; ++i) take_if(pair[i].excess < best.excess, pair[i], best);
    return best;
  }
};

struct LocalCrossings {
  Eight t, na, nb, nc, curvature;
};

// Does the same as same_plane() for eight edges: returns the edges whose samples lie on one plane, and sets their
// gradients in `out`.
TYPODONT_INLINE EightInts same_planes(const OneSidedGradients& p, const OneSidedGradients& q, Gradients& out) {
  Eight least = Eight{} + 2 * kSame * kSame;
  EightInts found{};
  for (int i = 0; i < 4; ++i) {
    const Gradients& g = p.pair[i];
    for (int j = 0; j < 4; ++j) {
      const Gradients& h = q.pair[j];
      const Eight off = (g.b - h.b) * (g.b - h.b) + (g.c - h.c) * (g.c - h.c);
      const EightInts take = (g.excess < kUnit) & (h.excess < kUnit) & (off < least);
      least = take ? off : least;
      take_if(take, g, out);
      found |= take;
    }
  }
  return found;
}

// Computes eight crossings as cross_edge() does. Returns one bit for each crossing that it cannot compute, because the
// crossing is near a crease.
TYPODONT_INLINE unsigned cross_eight(const float* const at[8], int a, int b, int c, LocalCrossings& out) {
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
  const OneSidedGradients here(f0, slope, lower_b0, upper_b0, lower_c0, upper_c0);
  const OneSidedGradients there(f1, slope, lower_b1, upper_b1, lower_c1, upper_c1);
  const EightInts bent = (absolute(bend0) > kBent) | (absolute(bend1) > kBent) | (absolute(b0) > kBent) |
                         (absolute(c0) > kBent) | (absolute(b1) > kBent) | (absolute(c1) > kBent);

  const Eight zero{};
  const Eight straight = f0 / (f0 - f1);
  Eight t = straight, curvature = zero;
  Gradients g, plane{};
  EightInts flat{};
  if (const EightInts unit = here.unit() & there.unit(); bits_of(unit) != 0) flat = same_planes(here, there, plane);
  if (bits_of(flat) != kAllLanes) {
    const Eight smaller_bend = bend0 * bend1 <= 0 ? zero : absolute(bend0) < absolute(bend1) ? bend0 : bend1;
    const Eight bend = absolute(bend0 + bend1) > kSlopeJump ? zero : smaller_bend;
    const Eight steep = slope - 0.5f * bend * (1 - 2 * t);
    t = absolute(steep) > 0.1f ? limited(t + 0.5f * bend * t * (1 - t) / steep, 0.f, 1.f) : t;
    g.a = slope - 0.5f * bend * (1 - 2 * t);
    g.b = 0.5f * ((1 - t) * (upper_b0 - lower_b0) + t * (upper_b1 - lower_b1));
    g.c = 0.5f * ((1 - t) * (upper_c0 - lower_c0) + t * (upper_c1 - lower_c1));
    g.excess = excess_of(g.a, g.b, g.c);
    curvature = 0.5f * (bend + (1 - t) * (b0 + c0) + t * (b1 + c1));
    if (const EightInts across = g.excess > kAcross; bits_of(across) != 0) {
      Gradients better = there.best();
      const Gradients best_here = here.best();
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
  const Eight length = root(g.a * g.a + g.b * g.b + g.c * g.c);
  const EightInts other = (bent & ~flat) | ~(length > 1e-6f);
  out = {t, g.a / length, g.b / length, g.c / length, curvature};
  return bits_of(other);
}

}  // namespace

TYPODONT_DISPATCH("avx2", "default")
void cross_edges(const float* field, const int stride[3], int axis, std::span<const GridEdge> edges, Crossing* out) {
  const int b_axis = (axis + 1) % 3, c_axis = (axis + 2) % 3;
  const int a = stride[axis], b = stride[b_axis], c = stride[c_axis];
  for (std::size_t first = 0; first < edges.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, edges.size() - first);
    const float* at[8];
    for (std::size_t i = 0; i < 8; ++i) at[i] = field + edges[first + std::min(i, count - 1)].sample;
    LocalCrossings eight;
    unsigned other = cross_eight(at, a, b, c, eight);
    for (; other; other &= other - 1) {
      const int i = std::countr_zero(other);
      const LocalCrossing one = cross_edge(at[i], a, b, c);
      eight.t[i] = one.t, eight.na[i] = one.na, eight.nb[i] = one.nb, eight.nc[i] = one.nc;
      eight.curvature[i] = one.curvature;
    }
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
