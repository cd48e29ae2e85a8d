// A sharp tip that sinks into soft tissue and sticks there. With this effect, a dental probe finds caries.
#pragma once

#include <algorithm>

#include "engine/base/pose.h"

namespace typodont::haptics {

struct TipLaw {
  double yield = 0;             // N, yield force of the tissue at the surface; 0: this tool never sinks
  double hardening = 1500;      // N/m, increase of the yield force with depth
  double grip = 0.6;            // ratio: force that pulls the tip out / force that pushes it in, at the same depth
  double depth_limit = 0.5e-3;  // m, largest depth of the tip in the tissue
};

struct TipState {
  double sunk = 0;   // m, depth of the tip in the tissue; 0: the tip is not sunk
  dvec3 p{0};        // m, workbench frame W, position of the head's centre at which the tip is held
  dvec3 n{0, 0, 1};  // unit vector in the workbench frame W, direction out of the tissue
};

/// Computes one tick of a sunk tip. The tip deforms only plastically, so it only absorbs energy. Its position p follows
/// the hand when the hand pushes harder than the yield force or pulls harder than the holding force. `stiffness`:
/// stiffness of the coupling, N/m; `soft`: true if the tissue ahead is so soft that the tip can sink deeper. Returns
/// the force on the tool, N. state.sunk becomes 0 when the tip comes out.
inline dvec3 tip_force(const TipLaw& law, const dvec3& hand, double stiffness, bool soft, TipState& state) noexcept {
  const double resistance = law.yield + law.hardening * state.sunk, holds = law.grip * resistance;
  dvec3 pull = hand - state.p;
  const double out = glm::dot(pull, state.n);
  if (stiffness * -out > resistance && soft && state.sunk < law.depth_limit) {
    // The tip sinks by the depth x at which two forces are equal: the force of the coupling, k (push - x), and the
    // force of the tissue, resistance + hardening x. k: stiffness of the coupling; push: distance from the tip inward
    // to the hand.
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
