// Functions for the hostile tests of all contact models: these pass invalid input (erratic_hand.h) to a
// bench, and check conditions that must hold in every tick.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "engine/base/units.h"
#include "tests/support/erratic_hand.h"
#include "tests/support/haptic_bench.h"

namespace typodont::test {

/// Limits of force and torque for the hostile tests.
constexpr double kHostileForceLimit = 8, kHostileTorqueLimit = 0.5;  // N, N·m
constexpr int kHostileRound = 4000;

/// Corrupts one tick in 50. If `undoes` is true, it sometimes also undoes a stroke.
inline void spoil(InvalidInput& nonsense, bool undoes, HapticBench& bench, ErraticHand& hand, Pose& X, double& pedal) {
  const InvalidInput::Other other = nonsense.spoil(hand, X, pedal);
  bench.t += other.clock;
  if (other.undo && undoes) bench.carver.undo();
}

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
