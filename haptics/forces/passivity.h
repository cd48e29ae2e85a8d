// The passivity controller: never gives the hand energy that the hand did not put in first.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// A force held for a tick gives the hand exactly F·Δx, and Δx is known only afterwards: an observer alone (Hannaford & Ryu
/// 2002) sees the loss a tick too late. So the force is bounded beforehand by what the ledger holds over the way the hand
/// may retreat in the next tick, foreseen from how fast it retreated lately and how fast a hand can turn round.
struct PassivityLaw {
  double margin = 2.5;        // of the fastest retreat lately: a tick may be missed, a retreat may quicken
  double memory = 0.05;       // s
  double turning = 2;         // m/s²: a hand that moves inward faster than turning × tick goes on moving inward …
  double human_tick = 1e-3;   // s, … in ticks this short; in longer ones it may go back as far as it came
  double credit = 0.8e-9;     // J, of the 1 nJ that rounding may cost
};

struct PassivityState {
  double retreat = 0;   // m in one tick: the longest way back lately, out of the tissue or against its own direction
  double advance = 0;   // m in one tick: the longest way in lately, against the force
  dvec3 moved{0};       // m, the tick before
};

/// The share, 0..1, of force `f` (N, on the hand) that may be given. `moved`: the hand's way in the last tick, m; `energy`:
/// what the ledger holds, J.
inline double passive_share(const PassivityLaw& law, const dvec3& f, const dvec3& moved, double dt, double tick,
                            double energy, PassivityState& state) noexcept {
  state.retreat *= std::exp(-dt / law.memory);
  const double before = glm::length(state.moved);
  if (before > 0) state.retreat = std::max(state.retreat, -glm::dot(moved, state.moved) / before);
  state.moved = moved;
  const double strength = glm::length(f);
  if (!(strength > 0)) return 1;
  const double along = glm::dot(f, moved) / strength;  // > 0: with the force, outward
  state.retreat = std::max(state.retreat, along);
  state.advance = std::max(state.advance * std::exp(-dt / law.memory), -along);
  const double turn = law.turning * tick * tick;
  const double reversal = tick > 2.2 * law.human_tick ? turn + state.advance : turn + std::min(along, 0.0);
  const double way = std::max({law.margin * state.retreat, reversal, 1e-3 * turn});
  return std::clamp((energy + law.credit) / (strength * way), 0.0, 1.0);
}

}  // namespace typodont::haptics
