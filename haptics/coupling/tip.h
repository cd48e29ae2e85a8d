// A tip that sinks into soft tissue and sticks there, such as a probe that finds caries.
#pragma once

#include <algorithm>

#include "engine/base/pose.h"

namespace typodont::haptics {

struct TipLaw {
  double yield = 0;             // N, push above which the tip sinks; 0: it never sinks
  double hardening = 1500;      // N/m, increase of the yield force with depth
  double grip = 0.6;            // force that pulls the tip out divided by the force that pushes it in, at equal depth
  double depth_limit = 0.5e-3;  // m, largest depth to which the tip sinks
  double reach = 0;             // m, from the head's centre to the tip's end
  double ahead = 0.1e-3;        // m; distance below the tip's end at which the tissue must be soft
  double slew = 60;             // N/s, rate at which TipState::rest decreases
};

struct TipState {
  double penetration = 0;  // m, depth of the tip in soft tissue; 0: not in tissue
  dvec3 p{0};              // m, frame W, head's centre while the tissue holds the tip
  dvec3 n{0, 0, 1};        // unit vector out of the tissue, frame W
  dvec3 force{0};          // N, frame W, force on the tool in the last tick, including `rest`
  // N, frame W, added to the force. When the tip begins or ceases to replace the contact, `rest` is the difference of
  // the two forces, so that the force does not jump; then it decreases to zero.
  dvec3 rest{0};
};

/// Returns the force on the tool in N. The contact is plastic, so it only absorbs energy: state.p follows a push above
/// the yield force or a pull above the holding force. Where hard tissue stops the tip sideways, the tip comes out: its
/// penetration becomes 0. `stiffness`: N/m, coupling; `soft_at(p)`: true if the tissue at p (m, frame W) is soft.
template <class SoftAt>
dvec3 tip_force(const TipLaw& law, const dvec3& hand, double stiffness, const SoftAt& soft_at,
                TipState& state) noexcept {
  const double resistance = law.yield + law.hardening * state.penetration, holds = law.grip * resistance;
  dvec3 pull = hand - state.p;
  const double out = glm::dot(pull, state.n);
  if (stiffness * -out > resistance && state.penetration < law.depth_limit &&
      soft_at(state.p - (law.reach + law.ahead) * state.n)) {
    // Sinks by x, where `stiffness` (push - x) = resistance + hardening x. push: inward distance from tip to hand.
    const double x =
        std::min((stiffness * -out - resistance) / (stiffness + law.hardening), law.depth_limit - state.penetration);
    state.penetration += x;
    state.p -= x * state.n;
  } else if (stiffness * out > holds) {
    const double x = (stiffness * out - holds) / stiffness;
    state.p += std::min(x, state.penetration) * state.n;
    state.penetration -= x;
    if (state.penetration <= 0) {
      state.penetration = 0;
      return dvec3(0);
    }
  }
  pull = hand - state.p;
  dvec3 sideways = pull - glm::dot(pull, state.n) * state.n;
  const double length = glm::length(sideways);
  if (stiffness * length > resistance) {  // the tip ploughs sideways through soft tissue
    state.p += sideways * (1 - resistance / (stiffness * length));
    if (!soft_at(state.p - (law.reach + std::max(law.ahead - state.penetration, 0.0)) * state.n)) {
      state.penetration = 0;
      return dvec3(0);
    }
    pull = hand - state.p;
  }
  return -stiffness * pull;
}

}  // namespace typodont::haptics
