// Wear of a diamond by the tissue that it removes.
#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "engine/base/units.h"
#include "haptics/tool.h"
#include "tests/support/heads.h"
#include "tests/support/swinging_hand.h"

namespace typodont {
namespace {

using namespace literals;
using namespace haptics;
using test::HapticBench;

constexpr const char* kBlock = R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid":
  {"box": {"size_mm": [8, 8, 6], "center_mm": [0, 0, -3]}}}]})";

Tool head(HeadShape shape, double length) {
  Tool tool;
  tool.shape = shape, tool.diameter = 1.2_mm, tool.length = length;
  return tool;
}
Tool diamond(double grit = 107e-6) {
  Tool tool = head(HeadShape::kRoundEndCylinder, 4.0_mm);
  tool.grit = grit;
  return tool;
}

/// Two diamonds and a drill in dentin, which wears diamonds by the grinding ratio `ratio`.
struct Settings {
  double ratio = 5, rate = 1000, grit = 107e-6;
};
HapticBench bench_with(const Settings& with) {
  ServoSettings s = test::drill_settings("offset");
  s.tick = 1 / with.rate;
  s.tools = {diamond(with.grit), diamond(with.grit), head(HeadShape::kSphere, 1.2_mm)};
  s.tools[2].blades = 6;
  s.tool = s.tools[0];
  MaterialTable materials = test::plain_materials();
  for (Material& m : materials) m.grit = {0.8, 0.12e-6, 0.3, 0.5, with.ratio};
  return {TissueVolume(read_solids(Json::parse(kBlock, "block"))), s, materials};
}
/// The hand lies `x` beside the block's middle and sinks 1 N deep behind the proxy.
void press(HapticBench& bench, double x, double seconds, std::uint32_t tool) {
  const double above = bench.settings.tools[tool].half() + 0.05_mm, rest = above + 1.0_mm;
  for (int i = 0; i < 50; ++i) bench.tick({{x, 0, rest}}, 0, tool);
  double z = above;
  for (double t = 0; t < seconds; t += bench.settings.tick) {
    bench.tick({{x, 0, z}}, 1, tool);
    z = std::min(bench.last.X_WG.p.z, z) - 2.0_mm * bench.settings.tick;
    z = std::max(z, bench.last.X_WG.p.z - 1.0_mm);
  }
  for (int i = 0; i < 200; ++i) bench.tick({{x, 0, rest}}, 0, tool);
}

TEST(Wear, TheSurfaceOfAHeadIsThatOfItsMeridian) {
  const double r = 0.6_mm;
  EXPECT_NEAR(head(HeadShape::kSphere, 2 * r).area() / (4 * kPi * r * r), 1, 1e-12);
  EXPECT_NEAR(head(HeadShape::kCylinder, 4.0_mm).area() / (2 * kPi * r * (4.0_mm + r)), 1, 1e-12);
  EXPECT_NEAR(head(HeadShape::kRoundEndCylinder, 4.0_mm).area() / (kPi * r * (2 * 4.0_mm + r)), 1, 1e-12);
  for (const HeadShape shape : test::head_shapes()) {
    const Tool tool = head(shape, shape == HeadShape::kSphere ? 1.2_mm : 4.0_mm);
    const std::vector<HeadSample> samples = sample_head(tool, 1000);
    const double sum =
        std::accumulate(samples.begin(), samples.end(), 0.0, [](double s, const HeadSample& h) { return s + h.area; });
    EXPECT_NEAR(tool.area() / sum, 1, 2e-3) << name_of(shape);
  }
}

TEST(Wear, IsTheRemovedVolumeOverTheGrindingRatioAndTheVolumeOfTheGrainsAtEveryServoRate) {
  for (const double rate : {500.0, 1000.0, 4000.0})
    for (const double grit : {46e-6, 151e-6}) {
      HapticBench bench = bench_with({.rate = rate, .grit = grit});
      press(bench, 0, 1, 0);
      const double grains = grit * diamond().area(), removed = total(bench.last.removed);
      ASSERT_GT(removed, 0.05_mm3);
      EXPECT_NEAR(bench.last.wear * 5 * grains / removed, 1, 1e-9) << rate << " Hz, " << grit;
    }
}

TEST(Wear, EachToolOfTheTrayHasItsOwnAndADrillHasNone) {
  HapticBench bench = bench_with({});
  press(bench, -2.0_mm, 1, 0);
  const double first = bench.last.wear;
  EXPECT_GT(first, 0);
  press(bench, 2.0_mm, 0.5, 1);
  ASSERT_EQ(bench.last.tool, 1u);
  EXPECT_GT(bench.last.wear, 0);
  EXPECT_LT(bench.last.wear, first) << "a new bur";
  const double second = bench.last.wear;
  press(bench, 0, 0.3, 2);
  ASSERT_EQ(bench.last.tool, 2u);
  EXPECT_EQ(bench.last.wear, 0) << "blades";
  press(bench, 0, 0, 0);
  EXPECT_EQ(bench.last.wear, first);
  press(bench, 0, 0, 1);
  EXPECT_EQ(bench.last.wear, second);
}

TEST(Wear, AtEqualLoadADiamondRemovesOnePlusWearTimesLessThanANewOneAndUndoDoesNotSharpenIt) {
  HapticBench bench = bench_with({.ratio = 0.5});
  // Rate × (1 + wear) in two depths of a hole, m³/s; the hand stays 1 mm below the tool, which gives 1 N.
  const auto drill = [&] {
    const double top = diamond().half();
    std::array<double, 2> rates;
    double z = top + 0.05_mm;
    bench.tick({{0, 0, z}}, 1);
    for (const double depth : {0.8_mm, 1.8_mm}) {
      double begin = 0, removed = 0, wear = 0;
      for (int i = 0; i < 20000 && bench.last.X_WG.p.z > top - depth - 0.2_mm; ++i) {
        bench.tick({{0, 0, z}}, 1);
        z = std::max(z - 2.0_mm * bench.settings.tick, bench.last.X_WG.p.z - 1.0_mm);
        if (begin == 0 && bench.last.X_WG.p.z < top - depth)
          begin = to_seconds(bench.t), removed = total(bench.last.removed), wear = bench.last.wear;
      }
      rates[depth > 1.0_mm] =
          (total(bench.last.removed) - removed) / (to_seconds(bench.t) - begin) * (1 + (wear + bench.last.wear) / 2);
    }
    for (int i = 0; i < 200; ++i) bench.tick({{0, 0, 6.0_mm}}, 1);
    return rates;
  };
  const auto [first, later] = drill();
  const double worn = bench.last.wear;
  EXPECT_GT(worn, 2);
  EXPECT_NEAR(later / first, 1, 0.02);
  ASSERT_TRUE(bench.carver.undo());
  for (int i = 0; i < 100; ++i) bench.tick({{0, 0, 6.0_mm}}, 1);
  EXPECT_EQ(bench.last.wear, worn) << "undo restores the tissue, not the bur";
  EXPECT_NEAR(drill()[0] / first, 1, 0.02);
}

TEST(Wear, GivesTheHandNoEnergyAndNoGreaterForceSteps) {
  double new_jump = 0;
  for (const double ratio : {0.0, 0.02, 0.2, 2.0}) {
    HapticBench bench = bench_with({.ratio = ratio});
    const test::SwingingHand hand{{0, 0, diamond().half() + 0.05_mm}, 1.5, 1.0_mm, 2};
    const test::Drilled run = test::drill(bench, hand, 1500, 60, [&](const ServoTick& tick, double work) {
      ASSERT_GE(tick.energy, -1e-9) << ratio;
      ASSERT_LE(tick.spindle_energy, work) << ratio;
    });
    if (ratio == 0) new_jump = run.jump;
    EXPECT_LE(run.jump, new_jump + 1e-3) << ratio;
    EXPECT_EQ(bench.last.wear > 0, ratio > 0);
  }
}

}  // namespace
}  // namespace typodont
