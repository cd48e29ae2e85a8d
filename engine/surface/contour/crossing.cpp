#include "engine/surface/contour/crossing.h"

#include <algorithm>

namespace typodont::surface {
namespace {

// A jump of slope between the edge's ends that no curvature explains.
constexpr float kSlopeJump = 0.6f;
// |∇|² of an exact plane differs from one by rounding only, and its gradients at two samples agree; a curved field
// does both at once only by a rare chance.
constexpr float kUnit = 2e-6f;
constexpr float kSame = 1e-5f;

float smaller(float p, float q) { return p * q <= 0 ? 0 : std::abs(p) < std::abs(q) ? p : q; }

struct Gradient {
  float a, b, c;
  float excess() const { return std::abs(a * a + b * b + c * c - 1); }
};

// One-sided differences at a sample, `slope` along the edge given: the pair whose gradient is nearest to length one.
Gradient one_sided(const float* p, float slope, int b, int c) {
  const float f = *p;
  const float bs[2] = {p[b] - f, f - p[-b]}, cs[2] = {p[c] - f, f - p[-c]};
  Gradient best{slope, bs[0], cs[0]};
  for (int i = 1; i < 4; ++i) {
    const Gradient other{slope, bs[i & 1], cs[i >> 1]};
    if (other.excess() < best.excess()) best = other;
  }
  return best;
}

}  // namespace

LocalCrossing cross_edge(const float* at, int a, int b, int c) {
  const float before = at[-a], f0 = at[0], f1 = at[a], after = at[2 * a];
  const float slope = f1 - f0;
  const float bend0 = before - 2 * f0 + f1, bend1 = f0 - 2 * f1 + after;
  float t = f0 / (f0 - f1);
  Gradient g;
  float curvature = 0;

  const bool kink = bend0 * bend1 > 0 && std::abs(bend0 + bend1) > kSlopeJump;
  bool solved = false;
  if (kink) {
    // Two straight lines: through the samples before the edge and after it. Their maximum (a convex kink) or minimum.
    const float slope0 = f0 - before, slope1 = after - f1;
    const float t0 = slope0 != 0 ? -f0 / slope0 : -1.f, t1 = slope1 != 0 ? 1 - f1 / slope1 : -1.f;
    const bool in0 = t0 >= 0 && t0 <= 1, in1 = t1 >= 0 && t1 <= 1;
    const bool convex = bend0 > 0, leaving = f0 < 0;
    if (in0 || in1) {
      const bool first = in0 && (!in1 || (convex == leaving ? t0 <= t1 : t0 > t1));
      t = first ? t0 : t1;
      g = first ? one_sided(at, slope0, b, c) : one_sided(at + a, slope1, b, c);
      solved = true;
    }
  }
  if (!solved) {
    const float bend = kink ? 0 : smaller(bend0, bend1);
    const float steep = slope - 0.5f * bend * (1 - 2 * t);
    if (std::abs(steep) > 0.1f) t = std::clamp(t + 0.5f * bend * t * (1 - t) / steep, 0.f, 1.f);
    g.a = slope - 0.5f * bend * (1 - 2 * t);
    const float* end = at + a;
    g.b = 0.5f * ((1 - t) * (at[b] - at[-b]) + t * (end[b] - end[-b]));
    g.c = 0.5f * ((1 - t) * (at[c] - at[-c]) + t * (end[c] - end[-c]));
    const Gradient g0 = one_sided(at, slope, b, c), g1 = one_sided(end, slope, b, c);
    if (g0.excess() < kUnit && g1.excess() < kUnit && std::abs(g0.b - g1.b) < kSame && std::abs(g0.c - g1.c) < kSame) {
      g = g0;
    } else {
      // The Laplacian of a distance is the sum of the principal curvatures.
      const float across0 = at[b] + at[-b] + at[c] + at[-c] - 4 * f0, across1 = end[b] + end[-b] + end[c] + end[-c] - 4 * f1;
      curvature = 0.5f * (bend + (1 - t) * across0 + t * across1);
    }
  }
  const float length = std::sqrt(g.a * g.a + g.b * g.b + g.c * g.c);
  if (!(length > 1e-6f)) return {t, slope > 0 ? 1.f : -1.f, 0, 0, 0};
  return {t, g.a / length, g.b / length, g.c / length, curvature};
}

}  // namespace typodont::surface
