// A hand of 0.15 kg that drills. For tests of the haptics alone.
#pragma once

#include <cmath>

#include "tests/support/haptic_bench.h"

namespace typodont::test {

/// Damped by 5 N·s/m.
struct DrillingHand {
  HapticBench& bench;
  dvec3 x, v{0}, f{0};  // m, m/s, N; `f` is the force on the hand in the last tick

  /// Moves the hand by `pull` (N) and the force on it, and makes one tick.
  const ServoTick& move(const dvec3& pull, const dquat& R = {1, 0, 0, 0}) {
    const double dt = bench.settings.tick;
    v += dt * (pull - 5.0 * v + f) / 0.15;
    x += dt * v;
    f = bench.tick({x, R}, 1).f_T_W;
    return bench.last;
  }
};

/// Presses down and swings: springs of 2 N/mm pull the hand along x to its swing, and along y to 0.
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
  DrillingHand mass{bench, hand.start};
  Drilled run;
  for (int i = 0; i < ticks; ++i) {
    const double aside = hand.swing * std::sin(2 * kPi * hand.hz * (i * dt));
    const ServoTick& tick = mass.move({2000 * (aside - mass.x.x), -2000 * mass.x.y, -hand.push});
    if (i <= landing) bench.max_step = 0;
    run.impulse += tick.f_T_W.z * dt;
    run.work += tick.cutting_power * dt;
    see(tick, run.work);
  }
  run.jump = bench.max_step;
  run.volume = total(bench.last.removed);
  return run;
}

}  // namespace typodont::test
