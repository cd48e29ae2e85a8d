// Bounds of the distance by which a head approaches samples in one motion. Kernels skip samples from which the head
// recedes. Private to haptics/cutting.
#pragma once

#include <algorithm>
#include <cmath>

#include "haptics/cutting/meridian.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

/// Smallest and largest n·w over the samples within `reach` of `center`, where w is the motion of a sample in frame T,
/// and n any outward normal of the meridian's pieces `first` to `last`. `rho`: distance of `center` from the axis.
struct Advance {
  float slowest, fastest;
};
inline Advance advance_beside(const MeridianPiece& first, const MeridianPiece& last, const glm::vec3& center, float rho,
                              float reach, const glm::vec3& w) {
  const float across = std::sqrt(w.x * w.x + w.y * w.y);
  /// Component of the motion w away from the axis: largest and smallest value over the samples within `reach`.
  float most = across, least = -across;
  if (rho > reach) {
    const float inverse = 1 / rho, ux = center.x * inverse, uy = center.y * inverse, sine = reach * inverse,
                cosine = std::sqrt(1 - sine * sine);
    const float radial = w.x * ux + w.y * uy, round = std::abs(w.x * uy - w.y * ux);
    if (!(round * cosine <= radial * sine)) most = radial * cosine + round * sine;
    if (!(round * cosine <= -radial * sine)) least = radial * cosine - round * sine;
  }
  // Largest n·w (n: normal, w: motion). Along the meridian, n turns from the normal at its start (at a tip: straight
  // down) to the normal at its end. If n passes the direction of w, the largest n·w is |w|; otherwise it is at an end.
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
