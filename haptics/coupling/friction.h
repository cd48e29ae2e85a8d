// Friction with stick, creep and slip, without drift.
#pragma once

#include "engine/base/pose.h"

namespace typodont::haptics {

struct FrictionLaw {
  double static_coefficient = 0.2;
  double dynamic_coefficient = 0.15;
  double stiffness = 1000;  // N/m, stiffness of the tangential spring
  /// fraction of the break-away displacement below which the adhesion point does not move
  double stick_fraction = 0.5;
};

struct FrictionState {
  dvec3 w{0};  // m, adhesion point: the end of the tangential spring
  bool touching = false;
  bool slipping = false;
};

/// Tangential force on the tool in N, at most μ F_n (Hayward & Armstrong 2000, eq. 5; below a stick threshold, the
/// adhesion map is zero, so nothing drifts). `x`, `previous`: m, contact point now and in the last tick; `n`: unit
/// normal.
inline dvec3 friction_force(const FrictionLaw& law, const dvec3& x, const dvec3& previous, const dvec3& n,
                            double normal_force, FrictionState& state) noexcept {
  if (!(normal_force > 0)) {
    state = {};
    return dvec3(0);
  }
  if (!state.touching) state = {x, true, false};
  const double mu = state.slipping ? law.dynamic_coefficient : law.static_coefficient;
  const double z_max = mu * normal_force / law.stiffness;
  dvec3 z = x - state.w;
  z -= glm::dot(z, n) * n;
  const double length = glm::length(z);
  if (length > z_max) {
    state.slipping = true;
    const double kept = std::min(z_max, law.dynamic_coefficient * normal_force / law.stiffness);
    z *= length > 0 ? kept / length : 0;
    state.w = x - z;
  } else if (length > law.stick_fraction * z_max) {
    // The adhesion point creeps after the contact at the distance z. α = fraction / z_max rises from 0 at the threshold
    // to half of 1/z_max at break-away, so slow motion also breaks away. Then dynamic friction acts.
    const double fraction = 0.5 * (length / z_max - law.stick_fraction) / (1 - law.stick_fraction);
    dvec3 step = x - previous;
    step -= glm::dot(step, n) * n;
    if (glm::length(step) == 0) {
      state.slipping = false;
    } else {
      state.w += std::min(1.0, glm::length(step) * fraction / z_max) * z;
    }
  } else {
    state.slipping = false;
  }
  return -law.stiffness * z;
}

}  // namespace typodont::haptics
