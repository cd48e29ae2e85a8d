// Rounded unions and intersections of distance fields (Quilez).
#pragma once

#include <algorithm>
#include <cmath>

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

}  // namespace typodont
