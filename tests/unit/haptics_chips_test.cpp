// Chips of blades and grains, and the torque that a controlled motor holds its speed against.
#include <gmock/gmock.h>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/servo/chips.h"
#include "haptics/spindle.h"
#include "haptics/tool.h"
#include "tests/support/folder.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using namespace haptics;

constexpr EdgeLaw kLaw{0.5, 40e-6, 0.3, 0.54}, kGritLaw{3, 0.12e-6, 0.3, 0.5};

Tool bladed(int blades) {
  Tool tool;
  tool.blades = blades;
  return tool;
}
Tool diamond(double grit) {
  Tool tool;
  tool.diameter = 1.2_mm, tool.grit = grit;
  return tool;
}

TEST(Chips, OfBladesDivideTheFeedPerTurn) {
  EXPECT_NEAR(chip_thickness(bladed(2), 96e-6), 48e-6, 1e-12);
  EXPECT_NEAR(chip_thickness(bladed(3), 96e-6), 32e-6, 1e-12);
}

TEST(Chips, OfGrainsHaveTheVolumeOfTheFeed) {
  using P = ChipParameters;
  for (const double grit : {46e-6, 107e-6, 151e-6})
    for (const double feed : {1e-9, 12e-9, 0.4e-6}) {
      const double h = chip_thickness(diamond(grit), feed), a = P::grain_distance * grit;
      const double turn = 2 * kPi * 0.6_mm;  // way of a grain in one turn; each has the area a²
      EXPECT_NEAR(P::chip_width * h * h * turn / (feed * a * a), 1, 1e-12);
    }
  EXPECT_EQ(chip_thickness(diamond(107e-6), -1e-6), 0) << "pulled back";
}

TEST(Chips, OfGrainsTakeTwiceTheWorkWhereTheyFillTheSpaceAndHardlyMoreBelow) {
  for (const double grit : {46e-6, 107e-6, 151e-6}) {
    const double full = ChipParameters::chip_space * grit;
    EXPECT_NEAR(rubbing(diamond(grit), full), 2, 1e-12);
    EXPECT_LT(rubbing(diamond(grit), full / 2), 1.02);
    EXPECT_EQ(rubbing(diamond(grit), -full), 1);
  }
  EXPECT_EQ(rubbing(bladed(2), 1.0_mm), 1);
}

TEST(Chips, TheirEnergyFallsByThePowerOfTheirThicknessWithinTheMeasuredRange) {
  EXPECT_NEAR(energy_ratio(kLaw, 40e-6), 0.5, 1e-12);
  EXPECT_NEAR(energy_ratio(kLaw, 4e-6) / 0.5, std::pow(10, 0.3), 1e-12);
  EXPECT_EQ(energy_ratio(kLaw, 0), energy_ratio(kLaw, 0.4e-6)) << "a drill that stands still";
  EXPECT_EQ(energy_ratio(kLaw, -1), energy_ratio(kLaw, 0)) << "a drill that is pulled back";
  EXPECT_EQ(energy_ratio(kLaw, 1), energy_ratio(kLaw, 400e-6));
  EXPECT_EQ(energy_ratio({2, 40e-6, 0, 0}, 1e-6), 2);
}

/// J/mm³ and the torque (N·mm) of a tool with these edges that is fed into a block.
struct Drilled {
  double energy = 0, torque = 0;
};
Drilled drill(const Tool& edges, double feed, double krpm, double rate) {
  ServoSettings s;
  s.tick = 1 / rate;
  s.tool.shape = HeadShape::kRoundEndCylinder;
  s.tool.diameter = 2.0_mm, s.tool.length = 6.0_mm, s.tool.side_efficiency = 0.15;
  s.tool.blades = edges.blades, s.tool.grit = edges.grit;
  s.spindle.free_speed = krpm * kKrpm;
  s.stiffness = 1e6, s.damping = 0, s.force_limit = 1e6;
  s.friction = s.passivity = false;
  MaterialTable materials;
  for (Material& m : materials) m = {.stiffness = 1000, .specific_energy = 3e9, .blade = kLaw, .grit = kGritLaw};
  test::HapticBench bench(TissueVolume(read_solids(Json::parse(
                              R"({"voxel_mm": 0.1, "solids": [{"tissue": "cortical_bone", "solid":
        {"box": {"size_mm": [4, 4, 6], "center_mm": [0, 0, -3]}}}]})",
                              "block"))),
                          s, materials);
  double work = 0, angle = 0, before = 0, removed = 0;
  for (double t = 0; feed * t < 4.0_mm; t += s.tick) {
    const ServoTick& tick = bench.tick({{0, 0, s.tool.half() - feed * t}}, 1);
    if (feed * t < 2.0_mm) {
      before = total(tick.removed);
      continue;
    }
    work += tick.cutting_power * s.tick, angle += tick.spindle * s.tick, removed = total(tick.removed);
  }
  return {work / (removed - before) / kJoulePerCubicMillimetre, work / angle / kMillimetre};
}

TEST(Chips, ADrillAndADiamondPayForTheThicknessOfTheirOwnChipsAtEveryServoRate) {
  for (const double rate : {500.0, 1000.0, 4000.0})
    for (const double feed : {0.5_mm, 2.0_mm})
      EXPECT_NEAR(
          drill(bladed(2), feed, 1.2, rate).energy / (3 * energy_ratio(kLaw, chip_thickness(bladed(2), feed / 20))), 1,
          0.03)
          << rate << " Hz, " << feed;
  for (const double rate : {500.0, 1000.0, 4000.0})
    for (const double grit : {46e-6, 107e-6}) {
      Tool tool = diamond(grit);
      tool.diameter = 2.0_mm;
      const double feed = 2.0_mm / 20000;
      const double ratio = energy_ratio(kGritLaw, chip_thickness(tool, feed)) * rubbing(tool, feed);
      EXPECT_NEAR(drill(tool, 2.0_mm, 1200, rate).energy / (3 * ratio), 1, 0.03) << rate << " Hz, " << grit;
    }
  EXPECT_NEAR(drill(Tool{}, 2.0_mm, 1.2, 1000).energy, 3, 0.03) << "edges not stated";
}

TEST(Chips, AControlledMotorHoldsItsSpeedUpToTheStatedTorque) {
  const auto motor = [](double held) {
    return read_spindle(
        Json::parse(R"({"name": "m", "free_speed_krpm": 200, "stall_torque_Nmm": 6, "held_torque_Nmm": )" +
                        std::to_string(held) + "}",
                    "motor"));
  };
  const Spindle s = motor(3);
  EXPECT_EQ(s.lost_fraction(3e-3, 1), 0);
  EXPECT_EQ(s.lost_fraction(1.5e-3, 0.5), 0) << "pedal half way";
  EXPECT_NEAR(s.lost_fraction(4.5e-3, 1), 0.5, 1e-12);
  EXPECT_NEAR(s.lost_fraction(6e-3, 1), 1, 1e-12);
  EXPECT_THROW(motor(6), Error);
}

TEST(Chips, OfAToolWithBladesAndGrainsAreRefused) {
  const std::string said = test::refusal([] {
    (void)read_tool(Json::parse(R"({"shape": "sphere", "diameter_mm": 1.2, "blades": 6, "grit_um": 100})", "tool"));
  });
  EXPECT_THAT(said, testing::HasSubstr("one of them"));
}

}  // namespace
}  // namespace typodont
