// Sinks into soft tissue and sticks, as a probe that finds caries.
#pragma once

#include <algorithm>

#include "engine/base/pose.h"

namespace typodont::haptics {

struct TipLaw {
  double yield = 0;             // N, at the surface; 0: never sinks
  double hardening = 1500;      // N/m, increase of the yield force with depth
  double grip = 0.6;            // force out / force in, at the same depth
  double depth_limit = 0.5e-3;  // m, largest
};

struct TipState {
  double sunk = 0;   // m; 0: not sunk
  dvec3 p{0};        // m, W, head's centre where the tip is held
  dvec3 n{0, 0, 1};  // unit, W, outwards
};

/// Plastic, so it only absorbs. p follows a push above yield or a pull above holding. `stiffness`: N/m, coupling;
/// `soft`: can sink deeper. Returns N on the tool; state.sunk is 0 once out.
inline dvec3 tip_force(const TipLaw& law, const dvec3& hand, double stiffness, bool soft, TipState& state) noexcept {
  const double resistance = law.yield + law.hardening * state.sunk, holds = law.grip * resistance;
  dvec3 pull = hand - state.p;
  const double out = glm::dot(pull, state.n);
  if (stiffness * -out > resistance && soft && state.sunk < law.depth_limit) {
    // By x with k (push - x) = resistance + hardening x; push: from the tip inward to the hand.
    const double x =
        std::min((stiffness * -out - resistance) / (stiffness + law.hardening), law.depth_limit - state.sunk);
    state.sunk += x;
    state.p -= x * state.n;
  } else if (stiffness * out > holds) {
    const double x = (stiffness * out - holds) / stiffness;
    state.p += std::min(x, state.sunk) * state.n;
    state.sunk -= x;
    if (state.sunk <= 0) {
      state.sunk = 0;
      return dvec3(0);
    }
  }
  pull = hand - state.p;
  dvec3 sideways = pull - glm::dot(pull, state.n) * state.n;
  const double length = glm::length(sideways);
  if (stiffness * length > resistance) {  // the tip ploughs sideways through the tissue
    state.p += sideways * (1 - resistance / (stiffness * length));
    pull = hand - state.p;
  }
  return -stiffness * pull;
}

}  // namespace typodont::haptics
