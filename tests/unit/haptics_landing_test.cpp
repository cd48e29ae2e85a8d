// How a turning bur lands: the coupling gives way where its force would change faster than 18.5 N/s (servo laws 4).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using test::HapticBench;

constexpr const char* kBlock =
    R"({"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [12, 12, 8]}}}]})";
constexpr double kSurface = 4.8_mm;                         // m, height of the bur's centre when it touches
constexpr double kMass = 0.15, kDamping = 5, kSlew = 18.5;  // kg, N·s/m, N/s
constexpr std::uint32_t kLawsBefore = 3, kLaws = 4;

haptics::ServoSettings bur(std::uint32_t laws, double rate) {
  haptics::ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 1.6_mm;
  settings.spindle.free_speed = 300 * kKrpm;
  settings.tick = 1 / rate;
  settings.laws = laws;
  return settings;
}

/// A hand with the mass and the damping of the simulated hands comes down at some speed and pushes by a constant force.
struct Landing {
  HapticBench bench;
  double z = kSurface + 0.5_mm, v, push;  // m, m/s, N
  double touch_speed = 0;                 // m/s, when it first touched
  double worst = 0, least_energy = 0;     // N from tick to tick, J
  double lowest = 0;                      // m under the place of the first touch
  double given_way = 0;                   // N, the greatest difference of the coupling's force and the felt one
  double pulled = 0;                      // N, the greatest force toward the tissue

  Landing(std::uint32_t laws, double speed, double pushes, double rate = 1000)
      : bench(kBlock, bur(laws, rate)), v(-speed), push(pushes) {}
  void run(double seconds, double pedal = 1) {
    const double dt = bench.settings.tick;
    for (int i = 0; i < std::lround(seconds / dt); ++i) {
      const double before = bench.last.f_T_W.z;
      v += dt * (before - push - kDamping * v) / kMass;
      z += dt * v;
      const ServoTick& tick = bench.tick({{0, 0, z}}, pedal);
      if (touch_speed == 0 && tick.depth > 0) touch_speed = -v;
      worst = std::max(worst, std::abs(tick.f_T_W.z - before));
      least_energy = std::min(least_energy, tick.energy);
      lowest = std::max(lowest, kSurface - z);
      given_way = std::max(given_way, given());
      pulled = std::max(pulled, -tick.f_T_W.z);
    }
  }
  double given() const { return glm::length(bench.last.f_model_W - bench.last.f_T_W); }
};

TEST(Landing, OfATurningBurChangesTheForceByNoMoreThanTheSlewWhateverTheSpeedAndTheRate) {
  for (const double rate : {500.0, 1000.0, 4000.0}) {
    for (const double speed : {0.01, 0.04, 0.1}) {
      Landing landing(kLaws, speed, 0.5, rate);
      landing.run(0.6);
      EXPECT_LT(landing.worst, kSlew / rate + 1e-9) << rate << " Hz, " << speed << " m/s";
      EXPECT_GT(landing.least_energy, -1e-9) << rate << " Hz, " << speed << " m/s";
      EXPECT_LT(landing.pulled, 1e-12) << rate << " Hz, " << speed << " m/s";
    }
  }
}

TEST(Landing, ByTheThirdLawsTheHandsSpeedIsAStep) {
  Landing landing(kLawsBefore, 0.1, 0.5);
  landing.run(0.3);
  EXPECT_GT(landing.worst, 0.1);
}

// The force rises on a straight line while the hand is stopped: m v' = push - damping v - slew t. So with B = slew /
// damping and A = (push + m B) / damping the speed is A - B t + (v₀ - A) exp(-damping t / m), and its integral the way.
TEST(Landing, StopsAHandAsSoonAsAForceCanThatRisesAtTheSlew) {
  const double push = 0.4, T = kMass / kDamping, B = kSlew / kDamping, A = (push + kMass * B) / kDamping;
  for (const double speed : {0.05, 0.1}) {
    Landing landing(kLaws, speed, push);
    landing.run(0.5);
    const double v0 = landing.touch_speed;
    double t = 0, beyond = 1;  // s; the hand stops between them
    while (beyond - t > 1e-9) {
      const double s = (t + beyond) / 2;
      (A - B * s + (v0 - A) * std::exp(-s / T) > 0 ? t : beyond) = s;
    }
    const double way = A * t - B * t * t / 2 + (v0 - A) * T * (1 - std::exp(-t / T));
    EXPECT_NEAR(landing.lowest / way, 1, 0.06) << speed;  // a tick's way at the touch, and what the bur cuts meanwhile
  }
}

TEST(Landing, OfAHandThatComesSlowlyGivesNothingWay) {
  Landing now(kLaws, 0.004, 0.02), before(kLawsBefore, 0.004, 0.02);
  now.run(0.4), before.run(0.4);
  EXPECT_GT(now.bench.last.f_T_W.z, 0.01);
  EXPECT_EQ(now.given_way, 0);
  EXPECT_EQ(now.bench.last.f_T_W, before.bench.last.f_T_W);
  EXPECT_EQ(now.z, before.z);
}

TEST(Landing, OfAToolThatStandsIsAsItWas) {
  Landing now(kLaws, 0.1, 0.5), before(kLawsBefore, 0.1, 0.5);
  now.run(0.3, 0), before.run(0.3, 0);
  EXPECT_GT(now.worst, 0.05);
  EXPECT_EQ(now.bench.last.f_T_W, before.bench.last.f_T_W);
  EXPECT_EQ(now.z, before.z);
}

TEST(Landing, LeavesThePushThatTheHandGivesAndTheCouplingComesBackAsTheBurSinks) {
  Landing landing(kLaws, 0.04, 0.5);
  landing.run(1);
  EXPECT_NEAR(landing.bench.last.f_T_W.z, 0.5, 0.01);
  const double given = landing.given(), tool = landing.bench.last.X_WG.p.z, hand = landing.z;
  EXPECT_GT(given, 0.3);
  landing.run(2);
  EXPECT_NEAR(landing.bench.last.f_T_W.z, 0.5, 0.01);
  const double sunk = tool - landing.bench.last.X_WG.p.z;
  EXPECT_GT(sunk, 0.1_mm);
  EXPECT_NEAR(landing.z, hand, 0.02_mm);
  // A spring of 1 N/mm.
  EXPECT_NEAR(given - landing.given(), 1000 * sunk, 0.03);
}

TEST(Landing, GivesNoForceOnceTheHandHasLeftTheTissue) {
  Landing landing(kLaws, 0.1, 0.5);
  landing.run(0.3);
  EXPECT_GT(landing.given(), 0.3);
  landing.push = -0.5;  // it lifts off
  landing.run(0.5);
  EXPECT_GT(landing.z, kSurface + 5.0_mm);
  EXPECT_LT(landing.worst, kSlew / 1000 + 1e-9);
  EXPECT_GT(landing.least_energy, -1e-9);
  EXPECT_EQ(landing.bench.last.f_T_W, dvec3(0));
  EXPECT_EQ(landing.given(), 0);
}

}  // namespace
}  // namespace typodont
