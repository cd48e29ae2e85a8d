// A sharp tip that sinks into soft tissue and sticks there: how an explorer finds caries.
#pragma once

#include <algorithm>

#include "engine/base/pose.h"

namespace typodont::haptics {

struct TipLaw {
  double yield = 0;             // N that the tissue bears before the tip sinks; 0: this tool never sinks
  double hardening = 1500;      // N/m: each further depth bears more
  double grip = 0.6;            // of the force that drove it in, holds it on withdrawal
  double depth_limit = 0.5e-3;  // m
};

struct TipState {
  double sunk = 0;   // m; 0: not sunk
  dvec3 p{0};        // m, where the tip is held: the head's centre, W
  dvec3 n{0, 0, 1};  // unit, the way out
};

/// One tick of a sunk tip (plastic in both directions, so it only ever takes energy): the place p follows the hand when
/// it pushes harder than the tissue yields or pulls harder than it grips. `stiffness`: of the coupling, N/m; `soft`:
/// the tissue ahead lets it sink on. Returns the force on the tool, N; state.sunk is 0 once it has come out.
inline dvec3 tip_force(const TipLaw& law, const dvec3& hand, double stiffness, bool soft, TipState& state) noexcept {
  const double bears = law.yield + law.hardening * state.sunk, holds = law.grip * bears;
  dvec3 pull = hand - state.p;
  const double out = glm::dot(pull, state.n);
  if (stiffness * -out > bears && soft && state.sunk < law.depth_limit) {
    // Sinks until coupling and tissue balance: k (push - x) = bears + hardening x.
    const double x = std::min((stiffness * -out - bears) / (stiffness + law.hardening), law.depth_limit - state.sunk);
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
  if (stiffness * length > bears) {  // ploughs sideways
    state.p += sideways * (1 - bears / (stiffness * length));
    pull = hand - state.p;
  }
  return -stiffness * pull;
}

}  // namespace typodont::haptics
