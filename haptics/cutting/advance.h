// Computes whether a head approaches the samples near a point, for the kernels. Private to haptics/cutting.
#pragma once

#include <algorithm>
#include <cmath>

#include "haptics/cutting/meridian.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

/// Smallest and largest speed at which the head approaches the samples within `reach` of a point of its half plane:
/// extreme values of n·w over the normals n of some neighbouring pieces. `w`: motion, in T.
struct Advance {
  float slowest, fastest;
};
inline Advance advance_beside(const MeridianPiece& first, const MeridianPiece& last, const glm::vec3& center, float rho,
                              float reach, const glm::vec3& w) {
  const float across = std::sqrt(w.x * w.x + w.y * w.y);
  float most = across, least = -across;  // the component of w perpendicular to the axis
  if (rho > reach) {
    const float inverse = 1 / rho, ux = center.x * inverse, uy = center.y * inverse, sine = reach * inverse,
                cosine = std::sqrt(1 - sine * sine);
    const float radial = w.x * ux + w.y * uy, round = std::abs(w.x * uy - w.y * ux);
    if (!(round * cosine <= radial * sine)) most = radial * cosine + round * sine;
    if (!(round * cosine <= -radial * sine)) least = radial * cosine - round * sine;
  }
  // The normals rotate from the normal of the first piece to that of the last piece; at a tip they begin at the
  // downward direction. If w lies between them, the maximum is at w itself.
  const bool tip = first.ax == 0.0f && rho < reach + Sweep::kMargin;
  const float first_x = tip ? 0 : first.nax, first_z = tip ? -1 : first.naz;
  const auto greatest = [&](float away, float along) {
    if (first_x * along - first_z * away >= 0 && away * last.nbz - along * last.nbx >= 0)
      return std::sqrt(away * away + along * along);
    return std::max(first_x * away + first_z * along, last.nbx * away + last.nbz * along);
  };
  return {-greatest(-least, -w.z), greatest(most, w.z)};
}

}  // namespace typodont::haptics
