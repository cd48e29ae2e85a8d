// Rounded unions and intersections of distance fields (Quilez), and what fields of teeth and gum share.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"

namespace typodont {

/// Minimum of a and b, rounded where they differ by less than k (m).
inline double smooth_min(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}
inline double smooth_max(double a, double b, double k) {
  return -smooth_min(-a, -b, k);
}

/// Rises smoothly from 0 for x <= a to 1 for x >= b.
inline double smooth_step(double a, double b, double x) {
  const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// f(p + step) − f(p − step) along x, y and z.
template <class F>
dvec3 central_difference(const F& f, const dvec3& p, double step) {
  const dvec3 x(step, 0, 0), y(0, step, 0), z(0, 0, step);
  return {f(p + x) - f(p - x), f(p + y) - f(p - y), f(p + z) - f(p - z)};
}

/// First-order estimate d / |∇f| of the distance to the surface f = 0 from the value d = f(p). `step`: m, of the
/// gradient's differences. `least`: lower limit of |∇f|.
template <class F>
double first_order_distance(const F& f, const dvec3& p, double d, double step, double least) {
  return d / std::max(glm::length(central_difference(f, p, step) / (2 * step)), least);
}

/// Thickness of gum at the depth `deep` below its edge, m: the edge is rounded and has the thickness `edge`; further
/// down, the thickness approaches `thick` within about `swell`. Above the edge, it is negative.
inline double gum_thickness(double deep, double edge, double thick, double swell) {
  return deep > 0 ? edge * std::sqrt(std::min(deep / 0.5e-3, 1.0)) + (thick - edge) * (1 - std::exp(-deep / swell))
                  : deep / 1.5;
}

}  // namespace typodont
