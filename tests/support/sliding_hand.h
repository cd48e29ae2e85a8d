// A hand that slides over any tissue, and what it feels. For tests and benchmarks of places without an exact contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/haptic_bench.h"

namespace typodont::test {

struct SlidingHand {
  dvec3 center{0};        // m, the hand stays within `range` of the line through this point along z
  double range = 2e-3;    // m
  double depth = 0.1e-3;  // m, below the place where the tool rests
  double speed = 20e-3;   // m/s
  dquat R{1, 0, 0, 0};
  double turn = 2.4;  // rad, change of direction in each quarter of a second
};

struct SlideResult {
  std::vector<double> times;      // ns, of each tick in contact
  int ticks = 0;                  // since the first contact
  double step_beyond_motion = 0;  // N
};

/// Slides for `seconds`, with the spring alone. The hand starts at bench.last. A force step beyond the hand's motion
/// exceeds `gain` times the stiffness times the way of the hand in this tick.
inline SlideResult slide(HapticBench& bench, const SlidingHand& hand, double seconds, double gain) {
  constexpr double kStraight = 0.25;  // s
  const double dt = bench.settings.tick;
  SlideResult result;
  dvec3 n(0, 0, 1), f(0);
  double sunk = 0;
  int touching = 0;
  for (int i = 0; touching < seconds / dt && i < 4 * seconds / dt + 1000; ++i) {
    const dvec3 at = bench.last.X_WT.p, rest = bench.last.X_WG.p;
    dvec3 next = at - 2 * hand.speed * dt * n;
    if (bench.last.depth > 0) {
      if (glm::length(rest - at) > 1e-7) n = glm::normalize(rest - at);
      const double a = hand.turn * std::floor(touching * dt / kStraight);
      const dvec3 back(hand.center.x - rest.x, hand.center.y - rest.y, 0);
      dvec3 way = glm::length(back) > hand.range ? back : dvec3(std::cos(a), std::sin(a), 0);
      way -= glm::dot(way, n) * n;
      sunk = std::min(hand.depth, sunk + 0.1 * hand.speed * dt);
      next = rest - sunk * n + hand.speed * dt * glm::normalize(way);
      ++touching;
    } else {
      n = {0, 0, 1}, sunk = 0;
    }
    bench.tick({next, hand.R});
    const double moved = glm::length(next - at), step = glm::length(bench.last.f_T_W - f);
    f = bench.last.f_T_W;
    if (touching == 0) continue;
    ++result.ticks;
    if (bench.last.depth > 0) result.times.push_back(static_cast<double>(bench.last.cpu_time));
    result.step_beyond_motion = std::max(result.step_beyond_motion, step - gain * bench.settings.stiffness * moved);
  }
  return result;
}

}  // namespace typodont::test
