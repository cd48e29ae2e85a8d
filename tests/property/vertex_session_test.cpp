// Whole sessions with the contact model "vertex": a bur that retreats under an overhang, and drilling in scenes that
// are turned or shifted.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>

#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using test::HapticBench;

haptics::ServoSettings drill(HeadShape shape, double length) {
  haptics::ServoSettings settings = test::drill_settings("vertex");
  settings.damping = 0.5;
  settings.tool.shape = shape;
  settings.tool.diameter = 1.0_mm, settings.tool.length = length;
  return settings;
}

// A cavity 1.4 mm high, below a ledge at x > -0.5 mm.
constexpr std::string_view kLedge = R"({"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"difference": [
  {"box": {"center_mm": [0, 0, -2], "size_mm": [8, 8, 4]}},
  {"box": {"center_mm": [0, 0, -1.5], "size_mm": [3, 4, 1.4]}},
  {"box": {"center_mm": [-1, 0, -0.4], "size_mm": [1, 4, 1]}}]}}]})";

/// Presses a turning bur below the ledge, then moves the hand 3 mm, with the given largest speed (m/s). Returns the
/// largest change of the force in a tick of the retreat, beyond the change by the hand's motion (N).
double step_in_retreat(double rate, double speed, const dvec3& press, const dvec3& way) {
  haptics::ServoSettings settings = drill(HeadShape::kSphere, 1.0_mm);
  settings.tick = 1 / rate;
  HapticBench bench(kLedge, settings);
  dvec3 p(0.6_mm, 0, -1.5_mm);
  const auto step = [&](const dvec3& to) {
    const dvec3 force = bench.last.f_T_W;
    const double moved = glm::distance(to, p);
    bench.tick({p = to}, 1);
    return glm::distance(bench.last.f_T_W, force) - settings.stiffness * moved;
  };
  for (int i = 0; i < 0.08 * rate; ++i) step(p + 10.0_mm / rate * press);
  EXPECT_GT(glm::dot(bench.last.f_T_W, -press), 0.2) << "nothing was pressed";
  constexpr double kWay = 3.0_mm;
  const dvec3 from = p;
  const int ticks = static_cast<int>(kPi / 2 * kWay / speed * rate);
  double worst = 0;
  for (int i = 1; i <= ticks; ++i) {
    worst = std::max(worst, step(from + kWay / 2 * (1 - std::cos(kPi * i / ticks)) * way));
  }
  for (int i = 0; i < 0.03 * rate; ++i) worst = std::max(worst, step(p));
  return worst;
}

class VertexRetreat : public testing::TestWithParam<int> {};

TEST_P(VertexRetreat, UnderAnOverhangTheForceOfATurningBurStepsByLittleMoreThanTheHandCauses) {
  const double rate = GetParam();
  for (const double speed : {0.02, 0.05, 0.09}) {  // m/s
    // At 500 Hz, a fast hand relaxes the spring within a few ticks, for which the ledger lacks energy.
    const double most = rate < 1000 && speed > 0.02 ? 0.1 : 0.05;
    for (const dvec3& press : {dvec3(0, 0, -1), dvec3(0, 0, 1), glm::normalize(dvec3(1, 0, -1))}) {
      // Back, along the ledge, across it, and out past its edge.
      for (const dvec3& way : {-press, dvec3(0, 1, 0), dvec3(-1, 0, 0), glm::normalize(dvec3(-1, 0, 1))}) {
        const double step = step_in_retreat(rate, speed, press, way);
        EXPECT_LE(step, most) << speed << " m/s, pressed along " << press.x << ' ' << press.z << ", way " << way.x
                              << ' ' << way.y << ' ' << way.z;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, VertexRetreat, testing::Values(500, 1000, 2000, 4000),
                         [](const auto& each) { return fmt::format("At{}Hz", each.param); });

/// A block of 8 × 8 × 4 mm in this pose; its top is at z = 0 of its own frame.
std::string block_at(const Pose& X_WB) {
  const std::pair<dvec3, double> sides[] = {{{1, 0, 0}, 4},  {{-1, 0, 0}, 4}, {{0, 1, 0}, 4},
                                            {{0, -1, 0}, 4}, {{0, 0, 1}, 0},  {{0, 0, -1}, 4}};
  std::string solids;
  for (const auto& [n_B, offset] : sides) {
    const dvec3 n = X_WB.R * n_B;
    solids += fmt::format(R"({}{{"halfspace": {{"normal": [{}, {}, {}], "offset_mm": {}}}}})",
                          solids.empty() ? "" : ", ", n.x, n.y, n.z, offset + 1e3 * glm::dot(n, X_WB.p));
  }
  return fmt::format(
      R"({{"voxel_mm": 0.2, "domain_mm": [[-8, -8, -8], [8, 8, 8]], "solids": [
          {{"tissue": "dentin", "solid": {{"intersection": [{}]}}}}]}})",
      solids);
}

/// Volume (m³) that a bur removes from the block in this pose: it goes in, 1.5 mm to the side, and out.
double drilled_volume(const Pose& X_WB, HeadShape shape, double tilted = 0.35, int rest = 400) {
  MaterialTable soft = test::plain_materials();
  for (Material& material : soft) material.specific_energy = 0.5e9;
  const haptics::ServoSettings settings = drill(shape, shape == HeadShape::kSphere ? 1.0_mm : 2.0_mm);
  HapticBench bench(block_at(X_WB), settings, soft);
  const double tip = settings.tool.half();
  const dquat tilt = glm::angleAxis(tilted, glm::normalize(dvec3(1, 2, 0)));
  dvec3 p_B(-0.8_mm, 0.1_mm, tip + 0.1_mm);
  const auto to = [&](const dvec3& end_B, int ticks) {
    const dvec3 from = p_B;
    for (int i = 1; i <= ticks; ++i) {
      p_B = from + static_cast<double>(i) / ticks * (end_B - from);
      bench.tick({X_WB * p_B, X_WB.R * tilt}, 1);
    }
  };
  to({-0.8_mm, 0.1_mm, tip - 0.4_mm}, 400);
  to({0.7_mm, 0.3_mm, tip - 0.4_mm}, 1000);
  to(p_B, rest);
  to({0.7_mm, 0.3_mm, tip + 1.0_mm}, 400);
  EXPECT_EQ(bench.last.f_T_W, dvec3(0)) << "it came out";
  return total(bench.last.removed);
}

/// Checks that a turned and a shifted scene lose the same volume, up to this relative difference.
void expect_equal_volumes(const std::function<double(const Pose&)>& drilled, double most) {
  const double volume = drilled({});
  EXPECT_GT(volume, 0.3e-9);
  std::mt19937 random(71);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 3; ++i) {
    const dquat R = glm::normalize(dquat(unit(random), unit(random), unit(random), unit(random)));
    const dvec3 shift = 0.1_mm * dvec3(unit(random), unit(random), unit(random));  // half a voxel at most
    EXPECT_NEAR(drilled({dvec3(0), R}) / volume, 1, most) << i;
    EXPECT_NEAR(drilled({shift}) / volume, 1, most) << i;
  }
}

class VertexPoses : public testing::TestWithParam<HeadShape> {};

TEST_P(VertexPoses, ATurnedOrShiftedSceneLosesTheSameVolumeToATiltedBur) {
  expect_equal_volumes([](const Pose& X_WB) { return drilled_volume(X_WB, GetParam()); }, 0.005);
}

TEST(VertexPosesUpright, ACylinderOnAFlatBottomReachesTheHandInTurnedAndShiftedScenes) {
  expect_equal_volumes([](const Pose& X_WB) { return drilled_volume(X_WB, HeadShape::kCylinder, 0, 2000); }, 0.015);
}

INSTANTIATE_TEST_SUITE_P(Shapes, VertexPoses, testing::Values(HeadShape::kSphere, HeadShape::kCylinder),
                         [](const auto& each) { return std::string(haptics::name_of(each.param)); });

}  // namespace
}  // namespace typodont
