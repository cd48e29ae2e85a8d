// Hands that no human has, for the hostile tests of all contact models: their motion, their invalid input, and the
// conditions that must hold in every tick.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "engine/base/units.h"
#include "haptics/bench/wanderer.h"
#include "tests/support/haptic_bench.h"

namespace typodont::test {

/// Limits of force and torque for the hostile tests.
constexpr double kHostileForceLimit = 8, kHostileTorqueLimit = 0.5;  // N, N·m
constexpr int kHostileRound = 4000;

using haptics::bench::Wanderer;

/// Invalid input as a broken device or clock would send it.
class Nonsense {
 public:
  /// `undoes`: also undo strokes.
  Nonsense(std::uint64_t seed, dvec3 home, bool undoes) : random_(seed), home_(home), undoes_(undoes) {}
  double pedal() { return uniform_(random_); }
  /// Corrupts one tick in 50: the hand, its pose, the pedal or the clock.
  void spoil(HapticBench& bench, Wanderer& hand, Pose& X, double& pedal) {
    switch (random_() % 450) {
      case 0:
        hand.leap_to(home_ + anywhere(6 * kMillimetre));
        break;
      case 1:
        X.p = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
        break;
      case 2:
        X.p = dvec3(std::numeric_limits<double>::infinity());
        break;
      case 3:
        X.R = dquat(0, 0, 0, 0);
        break;
      case 4:
        X.p = anywhere(1e30);
        break;
      case 5:
        pedal = std::numeric_limits<double>::quiet_NaN();
        break;
      case 6:
        bench.t -= 5'000'000;  // the clock goes backwards
        break;
      case 7:
        bench.t += 3'000'000'000;
        break;
      case 8:
        if (undoes_) bench.carver.undo();
        break;
      default:
        break;
    }
  }

 private:
  dvec3 anywhere(double size) {
    const double x = uniform_(random_), y = uniform_(random_), z = uniform_(random_);
    return size * dvec3(x, y, z);
  }
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
  dvec3 home_;
  bool undoes_;
};

inline haptics::ServoSettings hostile_settings(const haptics::Tool& tool) {
  haptics::ServoSettings s;
  s.tool = tool;
  s.spindle.free_speed = 300 * kKrpm;
  s.force_limit = kHostileForceLimit;
  s.torque_limit = kHostileTorqueLimit;
  return s;
}

/// Checks the conditions that must hold in every tick.
inline void expect_sense(const ServoTick& tick) {
  ASSERT_TRUE(is_finite(tick.f_T_W) && is_finite(tick.tau_T_W) && is_finite(tick.X_WG.p));
  ASSERT_TRUE(std::isfinite(tick.energy) && std::isfinite(tick.depth) && std::isfinite(tick.contact_area));
  ASSERT_LE(glm::length(tick.f_T_W), kHostileForceLimit * (1 + 1e-9));
  ASSERT_LE(glm::length(tick.tau_T_W), kHostileTorqueLimit * (1 + 1e-9));
}

}  // namespace typodont::test
