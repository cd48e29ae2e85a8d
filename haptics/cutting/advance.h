// Computes bounds of the speed at which a head (the cutting end of a tool) approaches the samples near a point. The
// kernels (vector functions) use these bounds to skip samples from which the head moves away. Private to
// haptics/cutting.
#pragma once

#include <algorithm>
#include <cmath>

#include "haptics/cutting/meridian.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

/// Lower and upper bound (`slowest`, `fastest`) of the speed at which the head approaches the samples within `reach` of
/// the point `center`. The speed is n·w, where w is the motion of the samples relative to the head, in the head's frame
/// T, and n is any normal of the neighbouring pieces `first` to `last` of the head's outline. `rho`: distance of
/// `center` from the head's axis.
struct Advance {
  float slowest, fastest;
};
inline Advance advance_beside(const MeridianPiece& first, const MeridianPiece& last, const glm::vec3& center, float rho,
                              float reach, const glm::vec3& w) {
  const float across = std::sqrt(w.x * w.x + w.y * w.y);
  /// most, least: greatest and least component of the motion w away from the head's axis, over the samples within
  /// `reach`
  float most = across, least = -across;
  if (rho > reach) {
    const float inverse = 1 / rho, ux = center.x * inverse, uy = center.y * inverse, sine = reach * inverse,
                cosine = std::sqrt(1 - sine * sine);
    const float radial = w.x * ux + w.y * uy, round = std::abs(w.x * uy - w.y * ux);
    if (!(round * cosine <= radial * sine)) most = radial * cosine + round * sine;
    if (!(round * cosine <= -radial * sine)) least = radial * cosine - round * sine;
  }
  // Finds the largest n·w, where w is the motion and n is any normal of these pieces of the head's outline. The normals
  // rotate from the first piece's normal to the last piece's normal. At a tip (the outline meets the axis), they begin
  // with the downward direction instead. If w has the direction of one of these normals, the maximum is |w|. Otherwise
  // it is the value for the first or for the last normal.
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
