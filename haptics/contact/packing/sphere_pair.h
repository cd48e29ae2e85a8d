// Contact time, distance and overlap of two spheres. Pure functions; any unit of length. S2: see docs/papers.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont::haptics::packing {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// First contact of a sphere that moves by `m`, as a fraction 0..1 of the motion, or kNever (paper S2, eq. 1). `D`:
/// vector to the other centre; `R`: sum of radii. If they touch at the start: 0 on approach, otherwise kNever.
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

/// Volume of the overlap of two spheres at distance `d` (S2, eq. 2): 0 if apart; the smaller sphere's volume if it is
/// inside. The printed equation lacks the denominator `12 * d` and the square of `r1 - r2`.
inline double lens_volume(double r1, double r2, double d) noexcept {
  if (!(d < r1 + r2)) return 0;
  const double least = std::min(r1, r2);
  if (d <= std::abs(r1 - r2)) return 4.0 / 3.0 * kPi * least * least * least;
  const double in = r1 + r2 - d, off = r1 - r2;
  return kPi * in * in * (d * d + 2 * d * (r1 + r2) - 3 * off * off) / (12 * d);
}

}  // namespace typodont::haptics::packing
