// Tests of laws of the force models: friction without drift, a tip that sinks in and sticks, exact distance fields of
// heads, and a field that is felt.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>

#include "engine/base/units.h"
#include "haptics/coupling/friction.h"
#include "haptics/coupling/tip.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/heads.h"
#include "tests/support/swinging_hand.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::FrictionLaw;
using haptics::FrictionState;
using haptics::HeadField;
using haptics::HeadShape;
using haptics::ServoSettings;
using haptics::Tool;
using test::DrillingHand;
using test::HapticBench;

/// Returns the motor's power (W) in a tick, on its torque line.
double motor_power(const ServoSettings& s, const ServoTick& tick) {
  return s.spindle.stall_torque * (1 - tick.spindle / s.spindle.free_speed) * tick.spindle;
}

/// Returns the energy (J) that the removed tissue took.
double cutting_energy(const HapticBench& bench) {
  double energy = 0;
  for (std::size_t i = 1; i < bench.last.removed.size(); ++i)
    energy += bench.last.removed[i] * bench.settings.materials[i].specific_energy;
  return energy;
}

TEST(Friction, AMillionCyclesBelowTheStickThresholdCauseNoDrift) {
  const FrictionLaw law;
  FrictionState state;
  const dvec3 n(0, 0, 1);
  dvec3 previous(0);
  friction_force(law, {0, 0, 0}, previous, n, 1.0, state);
  const FrictionState before = state;
  const double reach = 0.45 * law.static_coefficient * 1.0 / law.stiffness;
  for (int i = 0; i < 1'000'000; ++i) {
    const dvec3 x(reach * std::sin(0.1 * i), reach * std::cos(0.1 * i) * 0.8, 0);
    friction_force(law, x, previous, n, 1.0, state);
    previous = x;
  }
  EXPECT_EQ(state.w, before.w);
  EXPECT_EQ(state.slipping, before.slipping);
}

TEST(Friction, StaysInsideCoulombsConeAndInTheTangentPlaneOnAnyPath) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const FrictionLaw law;
  FrictionState state;
  dvec3 x(0), previous(0);
  for (int i = 0; i < 100'000; ++i) {
    const double push = 0.5 + 0.5 * uniform(random);
    const dvec3 n = glm::normalize(dvec3(0.3 * uniform(random), 0.3 * uniform(random), 1));
    x += 5e-5 * dvec3(uniform(random), uniform(random), uniform(random));
    const dvec3 f = friction_force(law, x, previous, n, push, state);
    ASSERT_LE(glm::length(f), law.static_coefficient * push * (1 + 1e-12)) << i;
    ASSERT_LE(std::abs(glm::dot(f, n)), 1e-12) << i;
    previous = x;
  }
}

TEST(Friction, FallsFromStaticToDynamicByNoMoreThanTheSlipInAnyDirection) {
  const FrictionLaw law{0.5, 0.4, 500};
  for (const double step : {0.1e-6, 2e-6, 20e-6}) {
    for (int k = 0; k < 24; ++k) {
      const dvec3 way = step * dvec3(std::cos(k * kPi / 12), std::sin(k * kPi / 12), 0);
      FrictionState state;
      dvec3 last(0);
      double most = 0;
      for (int i = 1; i * step < 3e-3; ++i) {
        const dvec3 f = friction_force(law, way * double(i), way * double(i - 1), {0, 0, 1}, 1.5, state);
        ASSERT_LE(glm::length(f - last), 2 * law.stiffness * step * (1 + 1e-9)) << step << ", " << k << ", " << i;
        most = std::max(most, glm::length(f));
        last = f;
      }
      EXPECT_GT(most, 0.95 * 0.5 * 1.5);
      EXPECT_NEAR(glm::length(last), 0.4 * 1.5, 1e-9);
      EXPECT_NEAR(glm::dot(last, way), -0.4 * 1.5 * step, 1e-9 * step) << k;
    }
  }
}

TEST(Tip, SinksUnderForceSticksOnWithdrawalAndIsPassive) {
  const haptics::TipLaw law{0.3};
  haptics::TipState state{1e-9, dvec3(0), {0, 0, 1}};
  double energy = 0, deepest = 0, most = 0;
  dvec3 held(0), at(0);
  const auto go = [&](double z) {
    const dvec3 hand(0, 0, z);
    energy -= glm::dot(held, hand - at);
    held = state.penetration > 0 ? tip_force(
                                       law, hand, 1000, [](const dvec3&) { return true; }, state)
                                 : dvec3(0);
    at = hand;
    deepest = std::max(deepest, state.penetration);
    most = std::min(most, held.z);
  };
  for (int i = 0; i < 1000; ++i) go(-i * 1e-6);
  EXPECT_GT(deepest, 0.1_mm);
  for (int i = 0; i < 2500; ++i) go(-1.0_mm + i * 1e-6);
  EXPECT_LT(most, -0.15);  // the tip had to be pulled out
  EXPECT_EQ(state.penetration, 0);
  EXPECT_GT(energy, 0);
}

TEST(Tip, PloughsThroughSoftTissueAndComesOutWhereHardTissueBegins) {
  for (const double border : {0.2_mm, 0.7_mm, 1.5_mm}) {
    const auto soft_at = [&](const dvec3& p) { return p.x < border; };
    haptics::TipState state{1e-9, dvec3(0), {0, 0, 1}};
    double farthest = 0;
    for (int i = 0; i < 3000 && state.penetration > 0; ++i) {
      const dvec3 hand(i * 2e-6, 0, -1.0_mm);
      const dvec3 f = haptics::tip_force({0.3}, hand, 1000, soft_at, state);
      if (!(state.penetration > 0)) break;
      farthest = state.p.x;
      ASSERT_LE(f.z, 1.0 + 1e-9);
      ASSERT_GE(f.x, -0.3 - 1500 * state.penetration - 1e-9) << border;
    }
    EXPECT_EQ(state.penetration, 0);
    EXPECT_NEAR(farthest, border, 3e-6);
  }
}

TEST(Heads, TheDistanceHasUnitSlopeAlongItsNormalAndTheNearestPointIsOnTheSurface) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const HeadShape shape : test::shapes_but_the_ball()) {
    Tool tool;
    tool.shape = shape;
    tool.diameter = 1.2_mm;
    tool.length = 3.0_mm;
    const HeadField head(tool, 1e-3);
    for (int i = 0; i < 3000; ++i) {
      const dvec3 p = 3.0 * dvec3(uniform(random), uniform(random), uniform(random));
      dvec3 n;
      const double d = head.distance(p, n);
      ASSERT_NEAR(glm::length(n), 1, 1e-9);
      if (d < 0) continue;
      ASSERT_NEAR(head.distance(p - d * n), 0, 1e-6);
      ASSERT_NEAR(head.distance(p + 0.5 * n), d + 0.5, 1e-6);
    }
  }
}

TEST(Heads, OnTheAxisOutsideABallTheDistanceIsPositive) {
  Tool tool;
  tool.diameter = tool.length = 1.2_mm;
  for (const double z : {-0.9, -0.61, 0.61, 0.75}) {
    dvec3 n;
    EXPECT_NEAR(HeadField(tool, 1e-3).distance({0, 0, z}, n), std::abs(z) - 0.6, 1e-12) << z;
    EXPECT_EQ(n, dvec3(0, 0, z < 0 ? -1 : 1)) << z;
  }
}

TEST(Contact, OnATorusForceErrorsAreAtMostTwoHundredthsOfADegreeAndOfAPercent) {
  ServoSettings s;
  s.friction = false;
  s.tool.diameter = s.tool.length = 1.0_mm;
  HapticBench bench(
      R"({"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"torus": {"major_mm": 5, "minor_mm": 2, "axis": [0.1, 0.2, 1]}}}]})",
      s);
  const dvec3 axis = glm::normalize(dvec3(0.1, 0.2, 1)), u = glm::normalize(glm::cross(axis, dvec3(1, 0, 0))),
              w = glm::cross(axis, u);
  const auto normal = [&](double a, double b) {
    return std::cos(b) * (std::cos(a) * u + std::sin(a) * w) + std::sin(b) * axis;
  };
  const auto at = [&](double a, double b, double r) {
    return 5.0_mm * (std::cos(a) * u + std::sin(a) * w) + r * normal(a, b);
  };
  for (double r = 4.0_mm; r > 2.1_mm; r -= 0.03_mm) bench.tick({at(0.3, 0.4, r)});
  for (int i = 0; i < 600; ++i) {
    const double a = 0.3 + i * 0.004, b = 0.4 + i * 0.006;
    const dvec3 f = bench.tick({at(a, b, 2.1_mm)}).f_T_W;
    if (i < 3) continue;
    ASSERT_LT(glm::length(glm::cross(glm::normalize(f), normal(a, b))) / kDegree, 0.02) << i;
    ASSERT_NEAR(glm::length(f), 0.4, 2e-4 * 0.4) << i;
  }
}

// If a cut is only a few voxels wide, interpolation can leave as much tissue as the energy of one tick can cut. This
// occurs with the tip of a flame and with a sharp rim. The head must not wait for this tissue, and must not alternate
// between two positions that are already cut.
TEST(Cutting, EqualForceRemovesEqualVolumeForEveryHeadAndTiltAtAnyVoxelSizeAndRate) {
  struct Run {
    const char* what;
    HeadShape shape;
    double diameter, length, push, swing, tilt;
    const char* tissue;
    double end_efficiency = 1;
  };
  const char* const enamel = R"([{"tissue": "enamel", "solid": {"box": {"size_mm": [5,5,4]}}}])";
  const char* const cap =
      R"([{"tissue": "dentin", "solid": {"box": {"size_mm": [5,5,4]}}}, {"tissue": "enamel", "solid": {"box": {"size_mm": [5,5,0.8], "center_mm": [0,0,1.6]}}}])";
  for (const Run& run :
       {Run{"flame, upright", HeadShape::kFlame, 1.1_mm, 3.4_mm, 1.3, 0, 0, cap},
        Run{"flame, hardly pressed", HeadShape::kFlame, 1.2_mm, 4.0_mm, 0.8, 0, 0, enamel},
        Run{"flame, tilted and swung", HeadShape::kFlame, 1.1_mm, 3.4_mm, 2.0, 0.3_mm, 0.4, enamel},
        // The force decides what a tip cuts with its end and what with its flank, even if it touches few samples.
        Run{"flame that cuts on its flank", HeadShape::kFlame, 1.4_mm, 5.0_mm, 0.9, 0, 0, enamel, 0.3},
        Run{"cone that cuts on its flank", HeadShape::kCone, 1.6_mm, 8.0_mm, 2.0, 0, 0, enamel, 0.3},
        Run{"inverted cone, upright", HeadShape::kInvertedCone, 1.1_mm, 1.0_mm, 1.5, 0, 0, enamel},
        Run{"inverted cone, on its rim", HeadShape::kInvertedCone, 1.0_mm, 0.9_mm, 1.2, 0, 0.5, cap},
        Run{"cylinder, end on", HeadShape::kCylinder, 1.0_mm, 4.0_mm, 1.5, 0, 0, cap},
        Run{"cylinder, lying", HeadShape::kCylinder, 0.9_mm, 3.0_mm, 1.5, 0, kPi / 2, enamel},
        Run{"ball, swung", HeadShape::kSphere, 0.8_mm, 0.8_mm, 1.0, 1.0_mm, 0, cap}}) {
    double least = 1e300, most = 0;
    for (const auto& [voxel_mm, rate] : {std::pair(0.1, 1000.0), std::pair(0.1, 4000.0), std::pair(0.05, 1000.0)}) {
      ServoSettings s;
      s.tool.shape = run.shape;
      s.tool.diameter = run.diameter;
      s.tool.length = run.length;
      s.tool.end_efficiency = run.end_efficiency;
      s.spindle.free_speed = 240.0_krpm;
      s.tick = 1 / rate;
      HapticBench bench(R"({"voxel_mm": )" + std::to_string(voxel_mm) + R"(, "solids": )" + run.tissue + "}", s);
      const double above = run.length / 2 * std::cos(run.tilt) +
                           (run.shape == HeadShape::kSphere ? 0 : run.diameter / 2 * std::sin(run.tilt));
      DrillingHand hand{bench, {0, 0, 2.0_mm + 0.03_mm + above}};
      for (double t = 0; t < 0.5; t += s.tick) {
        hand.move({2000 * (run.swing * std::sin(2 * kPi * t) - hand.x.x), -2000 * hand.x.y, -run.push},
                  glm::angleAxis(run.tilt, dvec3(0, 1, 0)));
        ASSERT_EQ(bench.last.faults, 0u) << run.what;
      }
      const double removed = total(bench.last.removed);
      least = std::min(least, removed), most = std::max(most, removed);
    }
    EXPECT_GT(least, 0.02_mm3) << run.what;
    EXPECT_LT(most / least, 1.02) << run.what;
  }
}

// A hand that oscillates by ±1.8 mm rolls a weak bur over the rims of its own pits, or the bur sticks in them. In both
// cases the cut volume equals the work of the motor's torque, also while the bur leaves the tissue and lands again.
TEST(Cutting, RemovedVolumeEqualsTheMotorsWorkAlsoOverTheRimsOfCuts) {
  struct Run {
    const char* what;
    HeadShape shape;
    // alike: largest allowed difference of the volumes, as a fraction
    double diameter, length, push, stall_torque, alike;
    double hardness = 1;  // factor on the specific energy
  };
  for (const Run& run :
       {Run{"ball, stuck in its hole", HeadShape::kSphere, 1.1_mm, 1.1_mm, 1.5, 1.6e-3, 0.01},
        Run{"ball in soft enamel", HeadShape::kSphere, 1.1_mm, 1.1_mm, 1.5, 1.6e-3, 0.02, 0.4},
        Run{"ball, rolling", HeadShape::kSphere, 1.1_mm, 1.1_mm, 0.7, 0.4e-3, 0.03},
        Run{"pear", HeadShape::kPear, 1.0_mm, 2.0_mm, 1.4, 1.0e-3, 0.02},
        Run{"cylinder in a pit too shallow for its wall", HeadShape::kCylinder, 1.0_mm, 3.5_mm, 1.1, 0.8e-3, 0.1},
        Run{"round-end cylinder", HeadShape::kRoundEndCylinder, 1.0_mm, 3.5_mm, 1.6, 1.2e-3, 0.02}}) {
    double least = 1e300, most = 0;
    for (const auto& [voxel_mm, rate] : {std::pair(0.1, 1000.0), std::pair(0.06, 1000.0)}) {
      ServoSettings s;
      s.tool.shape = run.shape;
      s.tool.diameter = run.diameter;
      s.tool.length = run.length;
      s.spindle.free_speed = 320.0_krpm;
      s.spindle.stall_torque = run.stall_torque;
      s.tick = 1 / rate;
      MaterialTable materials = test::plain_materials();
      materials[static_cast<std::size_t>(Tissue::kEnamel)].specific_energy *= run.hardness;
      HapticBench bench(R"({"voxel_mm": )" + std::to_string(voxel_mm) +
                            R"(, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [6,4,3]}}}]})",
                        s, materials);
      DrillingHand hand{bench, {0, 0, 1.53_mm + run.length / 2}};
      double work = 0;
      for (double t = 0; t < 2.2; t += s.tick) {  // at rest at the end, so that no energy waits for a later cut
        const double swing = t < 2 ? 1.8_mm * std::sin(2 * kPi * t) : 0;
        work += motor_power(s, hand.move({2000 * (swing - hand.x.x), -2000 * hand.x.y, -run.push})) * s.tick;
        if (t <= 0.3) bench.max_step = 0;
        ASSERT_EQ(bench.last.faults, 0u) << run.what;
      }
      const double removed = total(bench.last.removed);
      EXPECT_NEAR(cutting_energy(bench) / work, 1, 0.01) << run.what << " " << voxel_mm << " " << rate;
      EXPECT_LT(bench.max_step * rate / 1000, 0.02) << run.what;  // N a millisecond
      least = std::min(least, removed), most = std::max(most, removed);
    }
    std::printf("%s: %.4f to %.4f mm3\n", run.what, least * 1e9, most * 1e9);
    EXPECT_LT(most / least, 1 + run.alike) << run.what;
  }
}

/// Returns the settings of a ball on a motor with a torque line. `rate`: ticks per second.
ServoSettings ball(double diameter, double free_speed, double stall_torque, double rate) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = diameter;
  s.spindle.free_speed = free_speed;
  s.spindle.stall_torque = stall_torque;
  s.tick = 1 / rate;
  return s;
}

TEST(Cutting, TheSpindlesSpeedFollowsTheLoadWithTheRotorsInertia) {
  ServoSettings s = ball(1.2_mm, 350.0_krpm, 1.6e-3, 1000);
  s.spindle.run_up_time = 0.25;
  HapticBench bench(R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [12,3,8]}}}]})",
                    s);
  for (int k = 0; k < 3000; ++k) bench.tick({{-4.0_mm, 0, 8.0_mm}}, 1);
  EXPECT_NEAR(bench.last.spindle, s.spindle.free_speed, 1e-5 * s.spindle.free_speed);
  dvec3 x(-4.0_mm, 0, 4.61_mm), v(0);
  double slowest = s.spindle.free_speed, before = bench.last.spindle;
  const double kept = std::exp(-s.tick / s.spindle.run_up_time);
  // The hand moves along the surface and presses for 0.2 s, then lifts for 0.05 s, again and again.
  for (int k = 0; k < 4000; ++k) {
    const double push = k % 250 < 200 ? 1.5 : -0.5;
    v += s.tick * (dvec3(0, 0, -push) - 5.0 * v + bench.last.f_T_W) / 0.15;
    v.x = 2e-3;
    v.z = std::clamp(v.z, -0.05, 0.05);
    x += s.tick * v;
    x.z = std::min(x.z, 5.0_mm);
    const ServoTick& tick = bench.tick({x}, 1);
    ASSERT_LE(tick.spindle, s.spindle.free_speed - kept * (s.spindle.free_speed - before) * (1 - 1e-9)) << k;
    slowest = std::min(slowest, tick.spindle), before = tick.spindle;
  }
  EXPECT_LT(slowest, 0.9 * s.spindle.free_speed);
}

// A ball that the hand pulls forward comes out over the rim of its hole again and again, up to a millimetre behind the
// hand.
TEST(Cutting, ABurMovedOverTheRimOfItsHoleLandsAndCutsBeforeTheProxyReachesTheHand) {
  struct Run {
    // stiffness: of the spring between proxy and hand
    double diameter, speed, push, free_speed, stall_torque, stiffness;
    const char* tissue;
  };
  for (const Run& run : {Run{1.1_mm, 0.05, 1.24, 350.0_krpm, 1.6e-3, 2060, "dentin"},
                         Run{1.12_mm, 0.042, 1.12, 200.0_krpm, 6e-3, 18210, "dentin"},
                         Run{2.1_mm, 0.037, 1.52, 200.0_krpm, 6e-3, 1274, "dentin"},
                         Run{1.87_mm, 0.054, 0.7, 350.0_krpm, 1.6e-3, 2975, "enamel"}}) {
    double least = 1e300, most = 0;
    for (const auto& [voxel_mm, rate] : {std::pair(0.05, 1000.0), std::pair(0.1, 4000.0)}) {
      const ServoSettings s = ball(run.diameter, run.free_speed, run.stall_torque, rate);
      HapticBench bench(R"({"voxel_mm": )" + std::to_string(voxel_mm) + R"(, "solids": [{"tissue": ")" + run.tissue +
                            R"(", "solid": {"box": {"size_mm": [16,3,3]}}}]})",
                        s);
      const double damping = std::sqrt(run.stiffness * 0.15);
      dvec3 x(-6.0_mm, 0, 1.52_mm + run.diameter / 2), v(0), f(0);
      double work = 0;
      const double drawn = 10.0_mm / run.speed;
      for (double t = 0; t < drawn; t += s.tick) {
        const double at = -6.0_mm + run.speed * t;
        const dvec3 led(run.stiffness * (at - x.x) - damping * (v.x - run.speed), -2000 * x.y - 5 * v.y,
                        -run.push - 5 * v.z);
        v += s.tick * (led + f) / 0.15;
        x += s.tick * v;
        const ServoTick& tick = bench.tick({x}, 1);
        f = tick.f_T_W;
        work += motor_power(s, tick) * s.tick;
      }
      const double removed = total(bench.last.removed);
      EXPECT_NEAR(cutting_energy(bench) / work, 1, 0.02) << run.diameter << " " << voxel_mm << " " << rate;
      least = std::min(least, removed), most = std::max(most, removed);
    }
    std::printf("drawn ball of %.1f mm: %.4f to %.4f mm3\n", run.diameter * 1e3, least * 1e9, most * 1e9);
    EXPECT_LT(most / least, 1.04) << run.diameter;
  }
}

// At the edge of the cusp, the tissue no longer supports the bur. The hand falls, and reaches the bottom of the fissure
// with the speed that it has gained.
TEST(Cutting, AHandThatSlidesOffACuspLandsInTheFissureWithoutAForceStep) {
  for (const auto& [voxel_mm, rate] : {std::pair(0.1, 1000.0), std::pair(0.05, 1000.0), std::pair(0.1, 4000.0)}) {
    for (unsigned seed = 0; seed < 12; ++seed) {
      std::mt19937_64 dice(seed);
      const auto any = [&](double lo, double hi) { return std::uniform_real_distribution(lo, hi)(dice); };
      const double diameter = any(0.6_mm, 1.8_mm);
      const bool turbine = any(0, 1) < 0.5;
      const ServoSettings s =
          turbine ? ball(diameter, 350.0_krpm, 1.6e-3, rate) : ball(diameter, 200.0_krpm, 6e-3, rate);
      const double push = any(0.8, 2.2), phase = any(0, 2 * kPi), off = any(-0.3_mm, 0.3_mm);
      HapticBench bench(
          R"({"voxel_mm": )" + std::to_string(voxel_mm) + R"(, "solids": [{"tissue": "enamel", "solid": {"union": [
          {"sphere": {"center_mm": [2.3,0,0], "radius_mm": 2}}, {"sphere": {"center_mm": [-2.3,0,0], "radius_mm": 2}},
          {"box": {"center_mm": [0,0,-2], "size_mm": [9,6,4.2]}}]}}]})",
          s);
      DrillingHand hand{bench, {2.0_mm * std::sin(phase), off, 2.2_mm + diameter / 2}};
      for (double t = 0; t < 0.7; t += s.tick) {
        const double swing = 2.0_mm * std::sin(2 * kPi * t + phase);
        hand.move({2000 * (swing - hand.x.x), 2000 * (off - hand.x.y), -push});
        if (t <= 0.3) bench.max_step = 0;
      }
      EXPECT_LT(bench.max_step * rate / 1000, 0.02) << seed << " " << voxel_mm << " " << rate;  // N a millisecond
    }
  }
}

// The bur slides off a sphere's flank and continues to fall beside it. The force on the hand decreases over some time.
TEST(Cutting, ABurThatLeavesTheTissueCutsNothingWhileItsForceFades) {
  const ServoSettings s = ball(1.0_mm, 200.0_krpm, 20e-3, 1000);
  HapticBench bench(R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})", s);
  DrillingHand hand{bench, {1.3_mm, 0, 3.3_mm}};
  int in_contact = 0, falling = 0;
  for (double t = 0; t < 0.3; t += s.tick) {
    const ServoTick& tick = hand.move({2000 * (1.3_mm - hand.x.x), -2000 * hand.x.y, -2.3});
    if (tick.cutting_power > 0) {
      ++in_contact;
      EXPECT_LT(tick.spindle, s.spindle.free_speed);
    } else if (hand.x.z < -5.0_mm && tick.depth > 0) {
      ++falling;
      EXPECT_DOUBLE_EQ(tick.spindle, s.spindle.free_speed) << t;
    }
  }
  EXPECT_GT(in_contact, 10);
  EXPECT_GT(falling, 20);
}

TEST(Cutting, RemovalInLayersThinnerThanTwoVoxelsDoesNotDependOnTheVoxelSize) {
  struct Run {
    HeadShape shape;
    double diameter, length, penetration, swing, speed, free_speed, stall_torque;
    const char *top, *below;
  };
  for (const Run& run :
       {Run{HeadShape::kSphere, 1.41_mm, 1.41_mm, 1.2_mm, 4.0_mm, 0.087, 200.0_krpm, 6e-3, "enamel", "dentin"},
        Run{HeadShape::kSphere, 1.44_mm, 1.44_mm, 1.5_mm, 4.0_mm, 0.065, 200.0_krpm, 6e-3, "enamel", "dentin"},
        Run{HeadShape::kPear, 0.82_mm, 1.5_mm, 0.68_mm, 2.7_mm, 0.027, 200.0_krpm, 6e-3, "dentin", "enamel"}}) {
    double volume[2]{};
    for (int i = 0; i < 2; ++i) {
      const double voxel_mm = i == 0 ? 0.1 : 0.05;
      ServoSettings s = ball(run.diameter, run.free_speed, run.stall_torque, 1000);
      s.tool.shape = run.shape;
      s.tool.length = run.length;
      HapticBench bench(R"({"voxel_mm": )" + std::to_string(voxel_mm) + R"(, "solids": [{"tissue": ")" + run.top +
                            R"(", "solid": {"box": {"size_mm": [16,4,4]}}}, {"tissue": ")" + run.below +
                            R"(", "solid": {"box": {"size_mm": [16,4,3.7]}}}]})",
                        s);
      for (double t = 0; t < 0.5; t += s.tick) {
        const double z = 2.0_mm + s.tool.half() - run.penetration * std::min(1.0, t / 0.05);
        bench.tick({{run.swing * std::sin(run.speed / run.swing * t), 0, z}}, 1);
      }
      volume[i] = total(bench.last.removed);
    }
    std::printf("through layers: %.4f and %.4f mm3\n", volume[0] * 1e9, volume[1] * 1e9);
    EXPECT_NEAR(volume[0] / volume[1], 1, 0.02);
  }
}

// The groove is a twentieth of a voxel deep, so the tissue under the head is only slightly wider than a line.
TEST(Cutting, ABallSlidOverARoundToothRemovesTheVolumeOfItsMotorsWork) {
  struct Run {
    double diameter, around, depth, speed, free_speed, stall_torque;
    const char* tissue;
  };
  for (const Run& run : {Run{1.0_mm, 5.0_mm, 0.5_mm, 0.03, 200.0_krpm, 10e-3, "enamel"},
                         Run{1.2_mm, 6.6_mm, 0.4_mm, 0.04, 350.0_krpm, 1.6e-3, "enamel"},
                         Run{0.8_mm, 4.0_mm, 0.6_mm, 0.01, 200.0_krpm, 10e-3, "dentin"},
                         Run{1.9_mm, 4.4_mm, 0.7_mm, 0.016, 40.0_krpm, 30e-3, "dentin"}}) {
    for (const auto& [voxel_mm, rate] : {std::pair(0.1, 1000.0), std::pair(0.05, 1000.0), std::pair(0.1, 4000.0)}) {
      const ServoSettings s = ball(run.diameter, run.free_speed, run.stall_torque, rate);
      HapticBench bench(R"({"voxel_mm": )" + std::to_string(voxel_mm) + R"(, "solids": [{"tissue": ")" + run.tissue +
                            R"(", "solid": {"sphere": {"radius_mm": )" + std::to_string(run.around * 1e3) + "}}}]}",
                        s);
      double work = 0;
      for (double t = 0; t < run.around / run.speed; t += s.tick) {
        const double a = run.speed * t / run.around - 0.5, in = run.depth * std::min(1.0, t / 0.05);
        const ServoTick& tick =
            bench.tick({(run.around + run.diameter / 2 - in) * dvec3(std::sin(a), 0, std::cos(a))}, 1);
        work += motor_power(s, tick) * s.tick;
      }
      EXPECT_NEAR(cutting_energy(bench) / work, 1, 0.02) << run.diameter << " " << voxel_mm << " " << rate;
    }
  }
}

// A hand that jumps into the tissue gives the ledger hardly any energy, and if it then retreats a little and rests, it
// feels almost no force. Its bur must still cut.
TEST(Cutting, ABurThatIsPressedInAbruptlyCutsAtLeastHalfAsFastAsOneThatLandsSoftly) {
  struct Press {
    int ticks = 0, ticks_back = 0;  // durations of the push and of the retreat
    double further = 0;             // m, depth of the push beyond the depth of the rest
  };
  for (const char* tissue : {"enamel", "dentin"}) {
    for (const double depth : {0.5_mm, 1.0_mm}) {
      // m³ that the bur cuts in the first half second of the rest
      const auto cut_at_rest = [&](const Press& press) {
        HapticBench bench(std::string(R"({"voxel_mm": 0.1, "solids": [{"tissue": ")") + tissue +
                              R"(", "solid": {"box": {"size_mm": [6,6,6]}}}]})",
                          test::drill_settings("offset"));
        const auto move = [&](double from, double to, int ticks) {
          for (int i = 1; i <= ticks; ++i) {
            bench.tick({dvec3(0, 0, 3.6_mm - (from + (to - from) * i / ticks))}, 1);
            EXPECT_GE(bench.last.energy, -1e-9);
          }
        };
        const double deepest = depth + press.further;
        move(-0.1_mm, -0.1_mm, 200);
        move(-0.1_mm, deepest, press.ticks);
        move(deepest, depth, press.ticks_back);
        const double before = total(bench.last.removed);
        move(depth, depth, 500);
        return total(bench.last.removed) - before;
      };
      const double soft = cut_at_rest({500});
      for (const Press& press : {Press{1}, Press{3}, Press{5}, Press{3, 5, 0.1_mm}, Press{5, 5, 0.1_mm},
                                 Press{5, 20, 0.2_mm}, Press{5, 5, 0.4_mm}, Press{7, 20, 0.8_mm}}) {
        EXPECT_GT(cut_at_rest(press), 0.5 * soft)
            << tissue << ", rest at " << 1e3 * depth << " mm, " << 1e3 * press.further << " mm further in "
            << press.ticks << " ticks, back in " << press.ticks_back;
      }
    }
  }
}

// When a bur has drilled so deep that its shank, which is wider than the hole, reaches the tissue, the shank stops it.
// Then the shank carries the pushing force.
TEST(Cutting, AMotorDoesNoCuttingWorkWhileTheShankBlocksTheBur) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = 0.7_mm;
  s.tool.neck_diameter = 0.4_mm;
  s.tool.neck_length = 1.5_mm;
  s.tool.shank_diameter = 1.6_mm;
  s.tool.shank_length = 12.0_mm;
  s.spindle.free_speed = 180.0_krpm;
  s.spindle.stall_torque = 5e-3;
  HapticBench bench(R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [4,4,6]}}}]})",
                    s);
  DrillingHand hand{bench, {0, 0, 3.03_mm + s.tool.length / 2}};
  double work = 0, late = 0;
  for (int i = 0; i < 3000; ++i) {
    const double one = motor_power(s, hand.move({-2000 * hand.x.x, -2000 * hand.x.y, -1.8})) * s.tick;
    work += one;
    if (i >= 2800) late += one;
  }
  EXPECT_GT(bench.last.X_WG.p.z, -2.0_mm);  // the shank stopped it
  EXPECT_NEAR(cutting_energy(bench) / work, 1, 0.01);
  EXPECT_LT(late, 0.01 * work);
}

// A tip that is thinner than a voxel removes whole voxels. A motor of 10 mW needs many ticks to do the work for one
// voxel.
TEST(Cutting, APointedHeadCutsNoMoreThanTheWorkOfAWeakMotor) {
  for (const auto& [shape, diameter, length] :
       {std::tuple(HeadShape::kFlame, 1.7_mm, 5.0_mm), std::tuple(HeadShape::kCone, 1.4_mm, 4.0_mm)}) {
    for (const double voxel_mm : {0.1, 0.06}) {
      ServoSettings s;
      s.tool.shape = shape;
      s.tool.diameter = diameter;
      s.tool.length = length;
      s.spindle.free_speed = 3.0_krpm;
      s.spindle.stall_torque = 0.3;
      HapticBench bench(R"({"voxel_mm": )" + std::to_string(voxel_mm) +
                            R"(, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [4,4,3]}}}]})",
                        s);
      DrillingHand hand{bench, {0, 0, 1.52_mm + length / 2}};
      double work = 0;
      for (double t = 0; t < 2; t += s.tick)
        work += motor_power(s, hand.move({-2000 * hand.x.x, -2000 * hand.x.y, -0.9})) * s.tick;
      EXPECT_LT(cutting_energy(bench), 1.03 * work) << length << " " << voxel_mm;
      EXPECT_GT(total(bench.last.removed), 0.001_mm3);
    }
  }
}

TEST(Coupling, IsAnImplicitStepOfAMasslessToolAndStableAtAnyStiffnessAndRate) {
  // Zhao 2020, eq. 5, in one dimension: m Δv = h K (x_hand - x - h (v + Δv)). m is the tool's mass, K the coupling's
  // stiffness, and h the time step. There is an impenetrable wall at 0.
  const auto implicit_force = [](double m, double k, double h, double hand) {
    double x = 0.2_mm, v = 0;
    for (int i = 0; i < 2000; ++i) {
      v += h * k * (hand - x - h * v) / (m + h * h * k);
      x += h * v;
      if (x < 0) x = 0, v = 0;
    }
    return k * (x - hand);
  };
  const auto explicit_swing = [](double m, double k, double h, double hand) {  // without contact, about the hand
    double x = hand + 1e-6, v = 0, widest = 0;
    for (int i = 0; i < 400 && widest < 1; ++i) {
      const double a = k * (hand - x) / m;
      x += h * v, v += h * a;
      widest = std::max(widest, std::abs(x - hand));
    }
    return widest;
  };
  for (const double k : {1e3, 1e5, 1e6}) {
    for (const double h : {1e-4, 1e-3, 1e-2}) {
      ServoSettings s;
      s.tool.diameter = s.tool.length = 1.0_mm;
      s.tool.cuts = false;
      s.stiffness = k;
      s.tick = h;
      s.damping = 0;
      s.passivity = s.friction = false;
      s.force_limit = 1e9;
      HapticBench bench(
          R"({"voxel_mm": 0.2, "domain_mm": [[-3,-3,-4],[3,3,3]], "solids": [{"tissue": "enamel", "solid": {"halfspace": {"normal": [0,0,1], "offset_mm": 0}}}]})",
          s);
      const double depth = 0.4_mm;
      for (double z = 1.0_mm; z > 0.5_mm - depth; z -= 20e-6) bench.tick({{0.1_mm, 0, z}});
      double least = 1e300, most = 0;
      for (int i = 0; i < 50; ++i) {
        const double f = bench.tick({{0.1_mm, 0, 0.5_mm - depth}}).f_T_W.z;
        least = std::min(least, f), most = std::max(most, f);
      }
      EXPECT_EQ(least, most) << k << " " << h;
      EXPECT_NEAR(most / (k * depth), 1, 1e-6) << k << " " << h;
      EXPECT_NEAR(implicit_force(1e-9, k, h, -depth) / most, 1, 1e-6) << k << " " << h;
      if (h * h * k / 0.01 > 0.1) {
        EXPECT_GT(explicit_swing(0.01, k, h, -depth), 1e-3) << "a tool of 10 g, stepped explicitly";
      }
    }
  }
}

TEST(Servo, TheRecordedPosesGiveTheSameForcesBitForBit) {
  // Repeats recorded samples, as a replay does. The driver of the device gives orientations that have only
  // approximately unit length.
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.15, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]})";
  const haptics::DenseTissue dense = haptics::read_solids(Json::parse(kBlock, "tissue"));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  ServoSettings settings;
  settings.tool = haptics::read_tool(Json::load("assets/tools/cylinder_010.json"));
  settings.spindle.free_speed = 2e4;
  int touched = 0;
  for (int k = 0; k < 40; ++k) {
    const bool turns = k % 2 == 0;
    const dquat R = glm::angleAxis(0.8 * uniform(random), glm::normalize(dvec3(uniform(random), uniform(random), 0.2)));
    const double length = 1 + 4e-4 * uniform(random);
    HapticBench felt(haptics::TissueVolume(dense), settings), again(haptics::TissueVolume(dense), settings);
    for (int i = 0; i < 300; ++i) {
      const dquat R_WT = turns ? glm::slerp(dquat(1, 0, 0, 0), R, i / 300.0) : R;
      const double pedal = i > 150 ? 0.7 : 0.0;
      const ServoTick tick = felt.tick({{0.3e-3, -0.2e-3, 4.2e-3 - 8e-6 * i}, length * R_WT}, pedal);
      const ServoTick same = again.tick(tick.X_WT, tick.pedal, tick.tool, tick.faults);
      ASSERT_EQ(same.X_WT.p, tick.X_WT.p) << k << " " << i;
      ASSERT_EQ(same.X_WT.R, tick.X_WT.R) << k << " " << i;
      ASSERT_EQ(same.f_T_W, tick.f_T_W) << k << " " << i;
      ASSERT_EQ(same.tau_T_W, tick.tau_T_W) << k << " " << i;
      ASSERT_EQ(same.energy, tick.energy) << k << " " << i;
      touched += tick.depth > 0;
    }
    EXPECT_EQ(again.carver.volume().hash(), felt.carver.volume().hash()) << k;
  }
  EXPECT_GT(touched, 40 * 50);
}

TEST(Servo, AnEmergencyStopTakesTheForceAtOnceAndItsEndRestoresItWithoutAStep) {
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.15, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]})";
  HapticBench bench(kBlock, {});
  const auto tick = [&](double z, bool held) { return bench.tick({{0, 0, z}}, 0, 0, held ? bits(Fault::kHeld) : 0); };
  for (int i = 0; i < 300; ++i) tick(3.5e-3 - 4e-6 * i, false);  // more than half a millimetre into the block
  const double before = glm::length(bench.last.f_T_W);
  ASSERT_GT(before, 0.1);
  for (int i = 0; i < 500; ++i) {
    const ServoTick t = tick(2.3e-3 - 4e-6 * i, true);  // the bur is pressed against the block
    ASSERT_EQ(t.f_T_W, dvec3(0)) << i;
  }
  const double energy = bench.last.energy;
  for (int i = 0; i < 100; ++i) tick(0.3e-3, true);
  EXPECT_EQ(bench.last.energy, energy) << "what is not felt costs nothing";
  double last = 0;
  for (int i = 0; i < 40; ++i) {
    const double force = glm::length(tick(0.3e-3, false).f_T_W);
    ASSERT_LE(force - last, 0.12 * 4) << i;  // a fifteenth of the force per millisecond
    last = force;
  }
}

}  // namespace
}  // namespace typodont
