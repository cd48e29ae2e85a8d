// A hand of 0.15 kg that drills: it presses down and swings sideways. For tests of the haptics alone.
#pragma once

#include <algorithm>
#include <cmath>

#include "tests/support/haptic_bench.h"

namespace typodont::test {

/// Damped by 5 N·s/m. Springs of 2 N/mm pull the hand along x to its swing, and along y to 0.
struct SwingingHand {
  dvec3 start{0};                         // m, position at the first tick
  double push = 1, swing = 1e-3, hz = 1;  // N, downwards; m, amplitude along x; Hz
};

struct Drilled {
  double volume = 0;   // m³, removed from all tissues
  double impulse = 0;  // N·s, along z
  double work = 0;     // J, of the spindle
  double jump = 0;     // N, largest change of the force in a tick after the landing
};

/// Drills for `ticks` ticks, of which the first `landing` do not count for Drilled::jump. Calls see(tick, work so far).
template <class See>
Drilled drill(HapticBench& bench, const SwingingHand& hand, int ticks, int landing, See see) {
  const double dt = bench.settings.tick;
  dvec3 x = hand.start, v(0), f(0);
  Drilled run;
  for (int i = 0; i < ticks; ++i) {
    const dvec3 pull(2000 * (hand.swing * std::sin(2 * kPi * hand.hz * (i * dt)) - x.x), -2000 * x.y, -hand.push);
    v += dt * (pull - 5.0 * v + f) / 0.15;
    x += dt * v;
    const ServoTick& tick = bench.tick({x}, 1);
    if (i > landing) run.jump = std::max(run.jump, glm::length(tick.f_T_W - f));
    f = tick.f_T_W;
    run.impulse += f.z * dt;
    run.work += tick.cutting_power * dt;
    see(tick, run.work);
  }
  run.volume = total(bench.last.removed);
  return run;
}

}  // namespace typodont::test
