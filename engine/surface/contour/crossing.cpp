#include "engine/surface/contour/crossing.h"

#include <algorithm>

namespace typodont::surface {
namespace {

// |∇|² of an exact plane differs from one by rounding only, and its gradients at two samples agree; a curved field does
// so only by a rare chance.
constexpr float kUnit = 2e-6f;
constexpr float kSame = 3e-3f;
// Second differences beyond this are a crease nearby, or a radius under four voxels.
constexpr float kBent = 0.25f;
// A jump of slope between the edge's ends that no curvature explains.
constexpr float kSlopeJump = 0.6f;
// |∇|² of central differences is off by this much only where they reach across a crease.
constexpr float kAcross = 0.05f;

float smaller(float p, float q) { return p * q <= 0 ? 0 : std::abs(p) < std::abs(q) ? p : q; }

struct Gradient {
  float a = 0, b = 0, c = 0;
  float excess() const { return std::abs(a * a + b * b + c * c - 1); }
};

// The four pairs of one-sided differences across the edge at a sample, with a given slope along it.
struct OneSided {
  Gradient pair[4];
  int best = 0;
  OneSided(const float* p, float slope, int b, int c) {
    const float f = *p;
    const float bs[2] = {p[b] - f, f - p[-b]}, cs[2] = {p[c] - f, f - p[-c]};
    for (int i = 0; i < 4; ++i) {
      pair[i] = {slope, bs[i & 1], cs[i >> 1]};
      if (pair[i].excess() < pair[best].excess()) best = i;
    }
  }
  bool unit() const { return pair[best].excess() < kUnit; }
};

// One plane at both ends of the edge.
bool same_plane(const OneSided& p, const OneSided& q, Gradient& out) {
  if (!p.unit() || !q.unit()) return false;
  float least = 2 * kSame * kSame;
  bool found = false;
  for (const Gradient& g : p.pair) {
    if (g.excess() >= kUnit) continue;
    for (const Gradient& h : q.pair) {
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
  const float bent = std::max({std::abs(bend0), std::abs(bend1), std::abs(b0), std::abs(c0), std::abs(b1), std::abs(c1)});

  float t = f0 / (f0 - f1), curvature = 0;
  Gradient g;
  const OneSided here(at, slope, b, c), there(end, slope, b, c);
  bool solved = same_plane(here, there, g);
  if (!solved && bent > kBent) {
    // The edge may pass a crease: the field is the maximum (where it is convex) or minimum of a plane through the samples
    // before the edge and one through those after it.
    const float slope0 = f0 - before, slope1 = after - f1;
    const float t0 = slope0 != 0 ? -f0 / slope0 : -1.f, t1 = slope1 != 0 ? 1 - f1 / slope1 : -1.f;
    const bool in0 = t0 >= 0 && t0 <= 1, in1 = t1 >= 0 && t1 <= 1;
    const float jump = bend0 + bend1;
    if (bend0 * bend1 > 0 && (in0 || in1)) {
      const bool first = in0 && (!in1 || ((jump > 0) == (f0 < 0) ? t0 <= t1 : t0 > t1));
      const OneSided side = first ? OneSided(at, slope0, b, c) : OneSided(end, slope1, b, c);
      if (side.unit() || std::abs(jump) > kSlopeJump) {
        t = first ? t0 : t1;
        g = side.pair[side.best];
        solved = true;
      }
    }
    if (!solved && (here.unit() || there.unit())) {
      // A crease runs beside the edge: one of its ends sees a plane on one side.
      g = here.pair[here.best].excess() < there.pair[there.best].excess() ? here.pair[here.best]
                                                                          : there.pair[there.best];
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
    // The Laplacian of a distance is the sum of the principal curvatures.
    curvature = 0.5f * (bend + (1 - t) * (b0 + c0) + t * (b1 + c1));
    if (g.excess() > kAcross) {
      const Gradient &p = here.pair[here.best], &q = there.pair[there.best];
      const Gradient& better = p.excess() < q.excess() ? p : q;
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

}  // namespace typodont::surface
