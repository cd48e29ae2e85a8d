// Tests contact forces against analytic results.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "engine/base/units.h"
#include "haptics/cutting/carve.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::Servo;
using haptics::ServoSettings;
using haptics::Tool;
using test::HapticBench;

ServoSettings settings(double diameter) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = diameter;
  s.friction = false;
  return s;
}

constexpr const char* kSphere =
    R"({"voxel_mm": %g, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 5}}}]})";

std::string sphere(double voxel) {
  char text[200];
  std::snprintf(text, sizeof text, kSphere, voxel);
  return text;
}

/// A probe that feels the surface that another tool has cut. The carver makes the cuts, and the probe starts on a new
/// patch.
struct CutThenProbe {
  HapticBench bench;

  CutThenProbe(const std::string& tissue, const Tool& cutter, std::span<const Pose> path, double probe_diameter)
      : bench(tissue, [&] {
          ServoSettings s = settings(probe_diameter);
          s.tool.cuts = false;
          s.tools = {s.tool, cutter};
          return s;
        }()) {
    Cut cut;
    cut.tool = 1;
    for (std::size_t i = 0; i < path.size(); ++i) {
      cut.index = i + 1;
      cut.X_WA = path[i > 0 ? i - 1 : 0], cut.X_WB = path[i];
      bench.carver.apply(cut);
    }
  }
  /// Moves straight from `from` to `to`, then rests there.
  void probe(const dvec3& from, const dvec3& to) {
    for (int i = 0; i <= 100; ++i) bench.tick({glm::mix(from, to, i / 100.0)});
    for (int i = 0; i < 60; ++i) bench.tick({to});
  }
};

constexpr const char* kBlock =
    R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [6,6,6]}}}]})";

TEST(Contact, AConcaveCreaseLeftByACutIsFeltAtItsTrueDistance) {
  // An upright cylinder that is moved aside leaves a floor that meets a wall at a right angle.
  Tool bur;
  bur.shape = haptics::HeadShape::kCylinder;
  bur.diameter = 1.6_mm, bur.length = 4.0_mm;
  std::vector<Pose> path;
  for (int i = 0; i <= 40; ++i) path.push_back({{-1.013_mm + i * 0.05_mm, 0.021_mm, 4.137_mm}});
  const double floor = 2.137_mm, wall = 0.987_mm + 0.8_mm, r = 0.5_mm;
  for (const double angle : {25.0_deg, 45.0_deg, 65.0_deg}) {
    CutThenProbe scene(kBlock, bur, path, 1.0_mm);
    const dvec3 seat(wall - r, 0.021_mm, floor + r), push(std::sin(angle), 0, -std::cos(angle));
    scene.probe({0.5_mm, 0.021_mm, 4.2_mm}, seat + 0.3_mm * push);
    EXPECT_NEAR(scene.bench.last.X_WG.p.x, seat.x, 2e-6);  // a fiftieth of a voxel
    EXPECT_NEAR(scene.bench.last.X_WG.p.z, seat.z, 2e-6);
    EXPECT_LT(glm::length(scene.bench.last.f_T_W + 0.3 * push), 4e-3);
    EXPECT_EQ(scene.bench.last.faults, 0u);
  }
}

TEST(Contact, ACutDoesNotReduceTheAccuracyOnTheSurfaceBesideIt) {
  Tool bur;
  bur.diameter = bur.length = 1.0_mm;
  const Pose pit[] = {{{0, 0, 5.4_mm}}, {{0, 0, 5.0_mm}}};
  CutThenProbe scene(sphere(0.1), bur, pit, 1.0_mm);
  // Moves from the far side of the ball towards the pit. Until the head is near the pit, the direction must be correct
  // to a hundredth of a degree.
  for (double a = 90.0_deg; a > 50.0_deg; a -= 0.5_deg) {
    const dvec3 u(std::sin(a), 0, std::cos(a));
    if (a == 90.0_deg) scene.probe(6.0_mm * u, 5.2_mm * u);
    scene.bench.tick({5.2_mm * u});
    const dvec3 f = scene.bench.tick({5.2_mm * u}).f_T_W;
    EXPECT_LT(glm::length(glm::cross(f / glm::length(f), u)), std::sin(0.01_deg)) << a / kDegree;
    EXPECT_NEAR(glm::length(f), 0.3, 6e-5) << a / kDegree;
  }
}

TEST(Servo, ABallThatStartsInsideTissueIsLedOutTheShortestWayWithin50Milliseconds) {
  for (const double depth : {0.3_mm, 0.6_mm, 1.1_mm, 1.9_mm}) {  // from the end in to wholly inside
    ServoSettings s = settings(1.0_mm);
    s.friction = false;
    HapticBench bench(
        R"({"voxel_mm": 0.1, "band_mm": 3, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [9,9,6]}}}]})",
        s);
    const Pose X_WT{{0.13_mm, 0.07_mm, 3.5_mm - depth}, {1, 0, 0, 0}};
    double most = 0;
    for (int i = 0; i < 50; ++i) most = std::max(most, glm::length(bench.tick(X_WT).f_T_W));
    EXPECT_NEAR(bench.last.f_T_W.z, 1000 * depth, 0.02 * 1000 * depth) << depth;
    EXPECT_LE(most, 1000 * depth + 0.005) << depth;
    EXPECT_LT(std::abs(bench.last.n_C_W.x) + std::abs(bench.last.n_C_W.y), 0.03) << depth;
    EXPECT_EQ(bench.last.faults, 0u) << depth;
  }
}

/// Presses a ball of 1 mm 0.4 mm deep into the sphere. Returns the force, N.
double press(HapticBench& bench) {
  for (double z = 7.0_mm; z > 5.1_mm; z -= 0.02_mm) bench.tick({{0, 0, z}});
  for (int i = 0; i < 50; ++i) bench.tick({{0, 0, 5.1_mm}});
  return bench.last.f_T_W.z;
}

TEST(Servo, AHandLostInContactFeelsNormalContactWhenItReturnsElsewhere) {
  HapticBench bench(sphere(0.1), settings(1.0_mm));
  const double before = press(bench);
  EXPECT_NEAR(before, 0.4, 1e-3);
  for (const Fault gone : {Fault::kDeviceLost, Fault::kBadInput}) {
    for (int i = 0; i < 300; ++i) {  // the pose is still that of the last contact
      bench.tick({{0, 0, 5.1_mm}}, 1, 0, bits(gone));
      ASSERT_EQ(bench.last.f_T_W, dvec3(0));
      ASSERT_EQ(bench.last.faults, bits(gone));
    }
    // The hand is back at the resting position, 30 mm away. If the servo had still given the last force during this
    // jump, the energy debt would be 12 mJ.
    for (int i = 0; i < 100; ++i) bench.tick({{30.0_mm, 0, 7.0_mm}});
    EXPECT_EQ(bench.last.f_T_W, dvec3(0));
    for (double x = 30.0_mm; x > 0; x -= 0.1_mm) bench.tick({{x, 0, 7.0_mm}});
    EXPECT_NEAR(press(bench), before, 1e-6);
    EXPECT_GE(bench.last.energy, -1e-9);
  }
}

TEST(Servo, AfterAPauseOrAFaultInContactTheNextContactIsNormal) {
  for (const std::uint32_t told : {bits(Fault::kLetGo), 0u}) {
    HapticBench bench(sphere(0.1), settings(1.0_mm));
    const double before = press(bench);
    const double paid = bench.last.energy;
    bench.t += 80'000'000;  // the servo did not run while the hand left the tissue
    bench.tick({{0, 0, 5.6_mm}}, 0, 0, told);
    if (told) {
      EXPECT_EQ(bench.last.energy, paid);
    } else {
      EXPECT_LT(bench.last.energy, -1e-6);
    }
    for (double z = 5.6_mm; z < 7.0_mm; z += 0.02_mm) bench.tick({{0, 0, z}});
    EXPECT_NEAR(press(bench), before, 1e-6);
  }
}

TEST(Servo, ADamperThatKnowsTheEncoderResolutionDoesNotBuzz) {
  constexpr double kStep = 0.055e-3;
  // N, the largest change of force between two ticks, apart from the change that one encoder count causes
  const auto buzz = [&](double told) {
    ServoSettings s = settings(1.0_mm);
    s.position_step = told;
    s.passivity = false;  // the ledger would give nearly no force to a hand whose position changes in steps
    HapticBench bench(sphere(0.1), s);
    double worst = 0, last = 0;
    for (int i = 0; i < 2000; ++i) {
      const double z = 5.6_mm - 0.4_mm * std::sin(2 * kPi * i * 1e-3 / 2);  // slowly in and out
      bench.tick({{0, 0, kStep * std::round(z / kStep)}});
      const double f = bench.last.f_T_W.z;
      if (i > 0 && f > 0.05 && last > 0.05) worst = std::max(worst, std::abs(f - last) - 1000 * kStep);
      last = f;
    }
    return worst;
  };
  EXPECT_GT(buzz(0), 0.08);  // 2 Ns/m at 55 mm/s, which no hand had
  EXPECT_LT(buzz(kStep), 0.02);
}

TEST(Servo, FeelsASphereInTheTickOfArrivalAfterAnyFreeMotion) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(0, 1);
  HapticBench bench(sphere(0.1), settings(1.0_mm));
  const dvec3 u(0.6, 0.48, 0.64);
  double r = 7.0_mm;
  int touches = 0;
  for (int i = 0; i < 5000; ++i) {
    r = std::clamp(r + (any(random) < 0.3 ? 1.2_mm : 0.1_mm) * (2 * any(random) - 1), 5.3_mm, 7.5_mm);
    const ServoTick& tick = bench.tick({r * u});
    const double depth = std::max(0.0, 5.5_mm - r);
    ASSERT_NEAR(tick.depth, depth, 1e-3 * depth + 1e-9) << "tick " << i;
    touches += depth > 0;
  }
  EXPECT_GT(touches, 300);
}

}  // namespace
}  // namespace typodont
