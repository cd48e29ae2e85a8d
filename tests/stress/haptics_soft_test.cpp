// Tests soft tissue with hands that move as no human hand can.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/campaign.h"
#include "tests/support/hostile_hand.h"
#include "tests/support/soft_layer.h"

namespace typodont {
namespace {

using namespace literals;
using namespace test;

haptics::ServoSettings hostile_soft_settings(const haptics::Tool& tool) {
  haptics::ServoSettings settings = hostile_settings(tool);
  settings.soft = flat_layer();
  return settings;
}

TEST(HostileSoftTissue, AToolThroughTheLayerAtHalfAMetrePerSecondMeetsABoundedForceWithoutSteps) {
  for (const dvec3& way : {dvec3(0, 0, 1), dvec3(0.6, 0, 0.8), dvec3(0.99, 0, 0.14)}) {
    const std::vector<haptics::Tool> tools{ball_probe()};
    haptics::SoftTissue tissue(flat_layer(), tools, 1000);
    double strongest = 0, before = 0;
    Nanos t = 0;
    for (int pass = 0; pass < 6; ++pass) {
      for (int i = -16; i <= 16; ++i, t += 1'000'000) {
        const Pose X_WG{(pass % 2 == 0 ? -1.0 : 1.0) * 0.5_mm * i * way};  // down, then up
        const double force = tissue.at_rest(X_WG, 0) ? 0 : glm::length(tissue.tick({t, 1e-3, X_WG, 0, 0}).force);
        ASSERT_LE(force, 3 + 1e-9);
        ASSERT_LE(std::abs(force - before), 1000 * 0.5_mm + 0.021);  // the coupling times the way of a tick
        strongest = std::max(strongest, force);
        before = force;
      }
    }
    EXPECT_GT(strongest, 0.5);
  }
}

TEST(HostileSoftTissue, GivesNoEnergyToAnErraticHand) {
  const auto sessions = static_cast<std::uint32_t>(campaign(6));
  std::uint32_t felt = 0;  // sessions in which the hand found the gum
  for (std::uint32_t seed = 1; seed <= sessions; ++seed) {
    HapticBench bench(kBlockFarBelow, hostile_soft_settings(ball_probe()));
    ErraticHand hand(seed, dvec3(0, 0, 0.9_mm));
    double force = 0;
    for (int i = 0; i < kHostileRound; ++i) {
      const Pose at = hand.next(1e-3);
      const ServoTick& tick = bench.tick({at.p - dvec3(0, 0, 0.6_mm * (1 - std::cos(2e-3 * kPi * i))), at.R});
      ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "tick " << i;
      ASSERT_GE(tick.energy, -1e-9) << "tick " << i;
      force = std::max(force, glm::length(tick.f_T_W));
    }
    felt += force > 0.05;
  }
  EXPECT_GT(2 * felt, sessions);
}

TEST(HostileSoftTissue, StaysFiniteAndBoundedUnderTeleportsAndInvalidInput) {
  for (std::uint32_t seed = 1; seed <= static_cast<std::uint32_t>(campaign(4)); ++seed) {
    haptics::Tool tool = ball_probe();
    tool.cuts = seed % 2 == 0;
    HapticBench bench(kBlockFarBelow, hostile_soft_settings(tool));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    dvec3 p(0, 0, 1.0_mm), speed(0);
    dquat R(1, 0, 0, 0);
    for (int i = 0; i < kHostileRound; ++i) {
      speed = 0.9 * speed + 0.1 * dvec3(uniform(random), uniform(random), uniform(random));
      p += 1e-3 * speed;
      if (i % 97 == 0) p = 3.0_mm * dvec3(uniform(random), uniform(random), uniform(random));  // a teleport
      if (i % 131 == 0) R = glm::normalize(dquat(uniform(random), uniform(random), uniform(random), uniform(random)));
      p = glm::clamp(p, dvec3(-4.0_mm), dvec3(4.0_mm));
      Pose X{p, R};
      if (i % 211 == 0) X.p.x = std::numeric_limits<double>::quiet_NaN();
      if (i % 307 == 0) bench.t += 300'000'000;
      expect_sense(bench.tick(X, seed % 2 == 0 && i % 1000 > 500 ? 1 : 0));
      ASSERT_LE(bench.servo.soft()->active(), haptics::SoftTissue::kMaxActive);
    }
    for (std::uint32_t i = 0; i < bench.servo.soft()->surface().points().size(); ++i) {
      ASSERT_TRUE(std::isfinite(bench.servo.soft()->inward(i)));
    }
  }
}

}  // namespace
}  // namespace typodont
