// Friction between tool and tissue with stick, creep and slip, without drift.
#pragma once

#include <algorithm>

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
  const double z_static = law.static_coefficient * normal_force / law.stiffness;
  const double z_dynamic = std::min(z_static, law.dynamic_coefficient * normal_force / law.stiffness);
  const double z_max = state.slipping ? z_dynamic : z_static;
  const auto tangential = [&](const dvec3& v) { return v - glm::dot(v, n) * n; };
  dvec3 z = tangential(x - state.w);
  const double length = glm::length(z);
  if (length > z_max) {
    // While slipping, friction falls from static to dynamic by stiffness × slipped distance. kRounding: tolerance.
    constexpr double kRounding = 1 + 1e-9;
    const dvec3 held = tangential(previous - state.w);
    double kept = z_dynamic;
    if (glm::dot(held, held) > kRounding * z_dynamic * z_dynamic) {
      const double slid = glm::length(tangential(x - previous));
      kept = std::clamp(glm::length(held) - slid, z_dynamic, std::min(z_static, length));
    }
    state.slipping = true;
    z *= kept / length;
    state.w = x - z;
  } else if (length > law.stick_fraction * z_max) {
    // The adhesion point slowly follows the contact, which is displaced by z. α = fraction / z_max rises from 0 at
    // the threshold to 0.5 / z_max at break-away, so slow motion also breaks away and gets dynamic friction.
    const double fraction = 0.5 * (length / z_max - law.stick_fraction) / (1 - law.stick_fraction);
    const dvec3 step = tangential(x - previous);
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
