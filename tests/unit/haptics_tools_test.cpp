// Tests the tray: which tool the hand holds, and when it may take another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using haptics::ServoSettings;
using haptics::Tool;
using test::HapticBench;

constexpr const char* kBlock =
    R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [5,5,4]}}}]})";

Tool ball(double diameter, bool cuts = true) {
  Tool tool;
  tool.diameter = tool.length = diameter;
  tool.cuts = cuts;
  return tool;
}

/// Returns settings with four tools: round burs of 1.2 mm and 1.6 mm, a cylinder of 1 mm × 4 mm, and a probe of 0.5 mm.
ServoSettings four_tools() {
  ServoSettings s;
  s.tools = {ball(1.2_mm), ball(1.6_mm), ball(1.0_mm), ball(0.5_mm, false)};
  s.tools[2].shape = HeadShape::kCylinder;
  s.tools[2].length = 4.0_mm;
  s.tool = s.tools[0];
  s.friction = false;
  s.spindle.free_speed = 300.0_krpm;
  s.spindle.run_up_time = 20e-3;
  return s;
}

/// Moves to height z at 25 mm/s or less, and stays there until `ticks` ticks are over.
void run(HapticBench& bench, int ticks, double z, double pedal, std::uint32_t tool) {
  const double z0 = bench.t == 0 ? z : bench.last.X_WT.p.z;
  for (int i = 1; i <= ticks; ++i) {
    const double way = std::clamp(z - z0, -25e-6 * i, 25e-6 * i);
    bench.tick({{0, 0, z0 + way}}, pedal, tool);
  }
}

/// What the hand does for some ticks, which tool it asks for, and which it then has.
struct Phase {
  int ticks;
  double z;  // m
  std::uint32_t asks, has;
};
struct Change {
  const char* title;
  std::vector<Phase> phases;
};
class ToolTrayWithoutRotation : public testing::TestWithParam<Change> {};
TEST_P(ToolTrayWithoutRotation, ChangesTheToolWhenItMay) {
  HapticBench bench(kBlock, four_tools());
  for (const Phase& phase : GetParam().phases) {
    run(bench, phase.ticks, phase.z, 0, phase.asks);
    EXPECT_EQ(bench.last.tool, phase.has) << "at " << phase.z;
    EXPECT_EQ(bench.last.faults, 0u);
    EXPECT_EQ(glm::length(bench.last.f_T_W) > 0.04, phase.z < 2.55_mm);
  }
}
INSTANTIATE_TEST_SUITE_P(
    Changes, ToolTrayWithoutRotation,
    testing::Values(
        Change{"ImmediatelyWithoutContact", {{5, 5.0_mm, 0, 0}, {1, 5.0_mm, 3, 3}, {3, 5.0_mm, 2, 2}}},
        Change{"NotToAnInvalidNumber", {{5, 5.0_mm, 77, 0}}},
        Change{"NotInContactUntilItIsFree",
               {{50, 2.8_mm, 0, 0}, {200, 2.5_mm, 0, 0}, {100, 2.5_mm, 3, 0}, {8, 2.65_mm, 3, 3}}},
        // 0.1 mm above the block, and 0.1 mm inside it; then half a millimetre of the cylinder's end is inside
        Change{"NotToOneThatWouldTouchTissueUntilThereIsRoom",
               {{50, 2.7_mm, 0, 0}, {100, 2.7_mm, 1, 0}, {100, 3.5_mm, 2, 0}, {30, 4.05_mm, 2, 2}}}),
    [](const auto& change) { return change.param.title; });

TEST(ToolTray, ATurningDrillStaysInTheHandUntilItHasRunDown) {
  HapticBench bench(kBlock, four_tools());
  run(bench, 200, 5.0_mm, 1, 0);
  run(bench, 50, 5.0_mm, 1, 1);
  EXPECT_EQ(bench.last.tool, 0u);
  int waited = 0;
  while (bench.last.tool == 0 && waited < 1000) run(bench, 1, 5.0_mm, 0, 1), ++waited;
  EXPECT_EQ(bench.last.tool, 1u);
  EXPECT_NEAR(waited * 1e-3, 20e-3 * std::log(100.0), 3e-3);  // down to a hundredth of the free speed
}

TEST(ToolTray, ForceAndCutsAreThoseOfTheToolInTheHand) {
  HapticBench bench(kBlock, four_tools());
  run(bench, 5, 3.5_mm, 0, 0);
  run(bench, 5, 3.5_mm, 0, 1);
  run(bench, 300, 2.6_mm, 0, 1);  // 0.2 mm deep with its radius of 0.8 mm, in dentin of 0.5 N/mm
  EXPECT_NEAR(bench.last.f_T_W.z, 0.5 * 0.2, 1e-4);
  run(bench, 200, 2.6_mm, 1, 1);
  ASSERT_TRUE(bench.did_cut);
  EXPECT_EQ(bench.cut.tool, 1u);
}

TEST(ToolTray, ConstantChangesOfToolGiveNoForceStepAndEqualBitsInPatchAndVolume) {
  HapticBench bench(kBlock, four_tools());
  double last = 0, jump = 0;
  std::uint32_t seen = 0;
  for (int i = 0; i < 6000; ++i) {
    const double t = i * 1e-3;
    const double z = 2.75_mm + 1.6_mm * std::cos(2 * kPi * t) * std::cos(0.31 * t);
    bench.tick({{0.4_mm * std::sin(5 * t), 0, std::max(z, 2.45_mm)}}, z < 2.9_mm ? 1 : 0,
               static_cast<std::uint32_t>(i / 7 % 4));
    jump = std::max(jump, std::abs(bench.last.f_T_W.z - last));
    last = bench.last.f_T_W.z;
    seen |= 1u << bench.last.tool;
    EXPECT_EQ(bench.last.faults, 0u) << i;
  }
  EXPECT_EQ(seen, 15u);
  EXPECT_GT(bench.last.cuts, 500u);
  // The hand moves in at 10 mm/s or less. With a coupling of 0.5 N/mm, this changes the force by 5 mN per tick. The
  // damper adds up to 20 mN.
  EXPECT_LT(jump, 0.05);
  const haptics::TissuePatch& patch = bench.patch();
  std::vector<float> volume(patch.distance.size());
  bench.carver.volume().copy(patch.lo, glm::ivec3(patch.n), volume.data(), nullptr);
  EXPECT_TRUE(std::ranges::equal(patch.distance, volume));
}

TEST(ToolTray, ChangingToolsAllocatesNothing) {
  HapticBench bench(kBlock, four_tools());
  run(bench, 5, 5.0_mm, 0, 0);
  ServoTick out;
  Cut cut;
  std::uint32_t seen = 0;
  test::NoAlloc guard;
  for (std::uint32_t i = 0; i < 40; ++i) {
    bench.servo.tick({bench.t + i * 1000000, {{0, 0, 5.0_mm}}, 0, i % 4}, out, cut);
    seen |= 1u << out.tool;
  }
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_EQ(seen, 15u);
}

}  // namespace
}  // namespace typodont
