// Tests that "packing" counts the volume that the tissue loses, with heads of several shapes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/units.h"
#include "haptics/contact_method.h"
#include "haptics/dense_tissue.h"
#include "tests/support/haptic_bench.h"

namespace typodont::haptics {
namespace {

using namespace literals;

/// A head that is pressed into a block of dentin on a block of enamel, and moved sideways. Lengths in m.
struct Press {
  HeadShape shape;
  double diameter, length;
  double tilt;              // rad, angle of the tool's axis to the normal of the surface
  double sideways, newton;  // amplitude of the sideways motion; force
  double voxel, shift;      // shift: of the whole scene along x, y and z
  double rate;              // Hz
};

ServoSettings settings_of(const Press& press) {
  ServoSettings s = test::drill_settings(R"({"packing": {"spheres": 24000}})");
  s.tick = 1 / press.rate;
  s.tool.shape = press.shape, s.tool.diameter = press.diameter, s.tool.length = press.length;
  return s;
}
TissueVolume block(const Press& press) {
  const double at = press.shift * 1e3;
  return TissueVolume(read_solids(Json::parse(fmt::format(R"({{"voxel_mm": {}, "solids": [
      {{"tissue": "dentin", "solid": {{"box": {{"center_mm": [{}, {}, {}], "size_mm": [4, 4.6, 1]}}}}}},
      {{"tissue": "enamel", "solid": {{"box": {{"center_mm": [{}, {}, {}], "size_mm": [4, 4.6, 3]}}}}}}]}})",
                                                          press.voxel * 1e3, at, at, at - 0.5, at, at, at - 2.5),
                                              "block")));
}

class CountedVolume : public testing::TestWithParam<Press> {};

TEST_P(CountedVolume, IsTheLossOfTheFieldWithinFivePercent) {
  const Press press = GetParam();
  const ServoSettings settings = settings_of(press);
  test::HapticBench run(block(press), settings);
  const PerTissue before = run.carver.volume().volumes();
  const dquat R = glm::angleAxis(press.tilt, dvec3(0, 1, 0));
  double z = 3.0_mm;
  const auto tick = [&](double aside, double height, double pedal) {
    run.tick({dvec3(aside, 0, height) + press.shift, R}, pedal);
  };
  for (; z > 0 && !(run.last.f_T_W.z > 0.05); z -= 4e-3 / press.rate) tick(0, z, 0);
  const int ticks = static_cast<int>(2.5 * press.rate);
  for (int i = 0; i < ticks; ++i) {
    const double aside = press.sideways * std::sin(3.0 * i / press.rate);
    tick(aside, run.last.X_WG.p.z - press.shift - press.newton / settings.stiffness, 1);
  }
  const PerTissue after = run.carver.volume().volumes();
  double lost = 0, counted = 0;
  for (std::size_t t = 1; t < kTissueCount; ++t) {
    lost += before[t] - after[t], counted += run.last.removed[t];
    EXPECT_NEAR(run.last.removed[t], before[t] - after[t], 0.04_mm3) << name_of(static_cast<Tissue>(t));
  }
  ASSERT_GT(lost, 0.3_mm3);
  EXPECT_NEAR(counted / lost, 1, 0.05) << name_of(press.shape);
}

constexpr double kQuarterTurn = kPi / 2;
INSTANTIATE_TEST_SUITE_P(Heads, CountedVolume,
                         testing::Values(
                             // shape, diameter, length, tilt, sideways, force, voxel, shift, rate
                             Press{HeadShape::kSphere, 1.2_mm, 1.2_mm, 0, 0.4_mm, 0.8, 0.1_mm, 0.037_mm, 500},
                             Press{HeadShape::kSphere, 1.0_mm, 1.0_mm, 0, 0, 1.2, 0.07_mm, 0, 4000},
                             Press{HeadShape::kCone, 1.2_mm, 3.0_mm, 0, 0, 1, 0.1_mm, 0, 2000},
                             Press{HeadShape::kCone, 1.2_mm, 3.0_mm, 0, 0, 1, 0.1_mm, 0.037_mm, 2000},
                             Press{HeadShape::kCone, 1.4_mm, 2.4_mm, kQuarterTurn, 0.2_mm, 1.5, 0.08_mm, 0.021_mm, 500},
                             Press{HeadShape::kCone, 1.0_mm, 2.5_mm, 0.6, 0.5_mm, 1, 0.1_mm, 0.063_mm, 4000},
                             Press{HeadShape::kCylinder, 1.0_mm, 2.5_mm, 0, 0, 1, 0.1_mm, 0.05_mm, 2000},
                             Press{HeadShape::kCylinder, 1.2_mm, 3.0_mm, kQuarterTurn, 0.2_mm, 1.5, 0.07_mm, 0.011_mm,
                                   500},
                             Press{HeadShape::kCylinder, 0.8_mm, 2.0_mm, 0.5, 0.6_mm, 0.8, 0.1_mm, 0, 4000},
                             Press{HeadShape::kFlame, 1.2_mm, 3.6_mm, 0, 0, 1, 0.1_mm, 0.029_mm, 500},
                             Press{HeadShape::kFlame, 1.0_mm, 3.0_mm, kQuarterTurn, 0.3_mm, 1.5, 0.08_mm, 0, 2000},
                             Press{HeadShape::kFlame, 1.2_mm, 3.6_mm, 0.6, 0.5_mm, 1, 0.1_mm, 0.037_mm, 4000}));

}  // namespace
}  // namespace typodont::haptics
