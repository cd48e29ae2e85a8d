// Geometry of two spheres: time of contact, penetration depth, and volume of overlap. Pure functions, which work in any
// unit of length.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont::haptics::packing {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// Paper S2, eq. 1: returns the time at which a sphere that moves by `m` between time 0 and 1 first touches a sphere at
/// rest; kNever if it does not touch. `D`: vector from the moving centre to the other centre. `R`: sum of the radii. If
/// the spheres touch or overlap at the start, returns 0 if they approach (m·D > 0), and otherwise kNever, so that
/// overlapping spheres can always separate. In the paper's formula, the root is taken of the difference of two nearly
/// equal numbers, which loses precision. This function avoids the loss with (m·D)² - m²(D² - R²) = m²R² - |m × D|².
inline double contact_time(const dvec3& D, const dvec3& m, double R) noexcept {
  const double nearing = m.x * D.x + m.y * D.y + m.z * D.z;
  const double cx = m.y * D.z - m.z * D.y, cy = m.z * D.x - m.x * D.z, cz = m.x * D.y - m.y * D.x;
  const double discriminant = (m.x * m.x + m.y * m.y + m.z * m.z) * (R * R) - (cx * cx + cy * cy + cz * cz);
  const double apart = (D.x * D.x + D.y * D.y + D.z * D.z) - R * R;
  const double sum = nearing + std::sqrt(discriminant < 0 ? 0 : discriminant);
  const double root = (apart < 0 ? 0 : apart) / (nearing > 0 ? sum : 1);
  const bool touches = (nearing > 0) & ((apart <= 0) | (discriminant >= 0)) & (root <= 1);
  return touches ? root : kNever;
}

/// Paper S2, eq. 2: returns the volume of the overlap of two spheres with centre distance `d`. The volume is 0 if they
/// do not overlap, and the volume of the smaller sphere if it lies inside the larger one. The equation as printed in
/// the paper lacks the denominator and the square of the difference of radii; they are added here.
inline double lens_volume(double r1, double r2, double d) noexcept {
  if (!(d < r1 + r2)) return 0;
  const double least = std::min(r1, r2);
  if (d <= std::abs(r1 - r2)) return 4.0 / 3.0 * kPi * least * least * least;
  const double in = r1 + r2 - d, off = r1 - r2;
  return kPi * in * in * (d * d + 2 * d * (r1 + r2) - 3 * off * off) / (12 * d);
}

/// Returns the point of the segment from a to b that is nearest to p.
inline dvec3 nearest_on(const dvec3& a, const dvec3& b, const dvec3& p) noexcept {
  const dvec3 ab = b - a;
  const double length2 = glm::dot(ab, ab);
  if (!(length2 > 0)) return a;
  return a + std::clamp(glm::dot(p - a, ab) / length2, 0.0, 1.0) * ab;
}

}  // namespace typodont::haptics::packing
