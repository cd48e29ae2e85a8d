// Chips of bladed tools, and the torque that a controlled motor holds its speed against.
#include <gtest/gtest.h>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/servo/chips.h"
#include "haptics/spindle.h"
#include "haptics/tool.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using namespace haptics;

constexpr BladeLaw kLaw{0.5, 40e-6, 0.3, 0.54};

TEST(Chips, AreAsThickAsTheAdvanceDividedByTheTurnsAndTheBlades) {
  EXPECT_NEAR(chip_thickness(2.0_mm, 1.25_krpm, 2), 48e-6, 1e-12);
  EXPECT_NEAR(chip_thickness(0.8333_mm, 12.0_krpm, 2), 2.083e-6, 1e-9);
}

TEST(Chips, TheirEnergyFallsByThePowerOfTheirThicknessWithinTheMeasuredRange) {
  EXPECT_NEAR(energy_ratio(kLaw, 40e-6), 0.5, 1e-12);
  EXPECT_NEAR(energy_ratio(kLaw, 4e-6) / 0.5, std::pow(10, 0.3), 1e-12);
  EXPECT_EQ(energy_ratio(kLaw, 0), energy_ratio(kLaw, 0.4e-6)) << "a drill that stands still";
  EXPECT_EQ(energy_ratio(kLaw, -1), energy_ratio(kLaw, 0)) << "a drill that is pulled back";
  EXPECT_EQ(energy_ratio(kLaw, 1), energy_ratio(kLaw, 400e-6));
  EXPECT_EQ(energy_ratio({2, 40e-6, 0, 0}, 1e-6), 2);
}

/// J/mm³ and the torque (N·mm) of a drill that is fed into a block, by the stated number of blades.
struct Drilled {
  double energy = 0, torque = 0;
};
Drilled drill(int blades, double feed, double rate) {
  ServoSettings s;
  s.tick = 1 / rate;
  s.tool.shape = HeadShape::kRoundEndCylinder;
  s.tool.diameter = 2.0_mm, s.tool.length = 6.0_mm, s.tool.side_efficiency = 0.15, s.tool.blades = blades;
  s.spindle.free_speed = 1.2_krpm;
  s.stiffness = 1e6, s.damping = 0, s.force_limit = 1e6;
  s.friction = s.passivity = false;
  MaterialTable materials;
  for (Material& m : materials) m = {.stiffness = 1000, .specific_energy = 3e9, .blade = kLaw};
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

TEST(Chips, ADrillPaysForTheThicknessOfItsOwnChipsAtEveryServoRate) {
  for (const double rate : {500.0, 1000.0, 4000.0})
    for (const double feed : {0.5_mm, 2.0_mm})
      EXPECT_NEAR(drill(2, feed, rate).energy / (3 * energy_ratio(kLaw, chip_thickness(feed, 1.2_krpm, 2))), 1, 0.03)
          << rate << " Hz, " << feed;
  EXPECT_NEAR(drill(0, 2.0_mm, 1000).energy, 3, 0.03) << "without stated blades";
}

TEST(Chips, AControlledMotorHoldsItsSpeedUpToTheStatedTorque) {
  const auto motor = [](double held) {
    return read_spindle(
        Json::parse(R"({"name": "m", "free_speed_krpm": 200, "stall_torque_Nmm": 6, "held_torque_Nmm": )" +
                        std::to_string(held) + "}",
                    "motor"));
  };
  const Spindle s = motor(3);
  EXPECT_EQ(load_spindle(s, s.free_speed, 1, 3e-3).speed, s.free_speed);
  EXPECT_EQ(load_spindle(s, s.free_speed, 0.5, 1.5e-3).speed, s.free_speed) << "pedal half way";
  EXPECT_NEAR(load_spindle(s, s.free_speed, 1, 4.5e-3).speed / s.free_speed, 0.5, 1e-12);
  EXPECT_EQ(load_spindle(s, s.free_speed, 1, 6e-3).power, 0);
  EXPECT_THROW(motor(6), Error);
}

TEST(Chips, BladesOutsideOfPhysicsAreRefusedWithKeyAndRange) {
  try {
    (void)read_tool(Json::parse(R"({"shape": "sphere", "diameter_mm": 1.2, "blades": 65})", "tool"));
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("blades"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("64"), std::string::npos);
  }
}

}  // namespace
}  // namespace typodont
