// Temperatures of pulp and bone under synthetic ticks.
#include <gtest/gtest.h>

#include "engine/app/assets.h"
#include "engine/app/scene.h"
#include "engine/app/task/heat.h"
#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont {
namespace {

using namespace literals;

constexpr double kFlow = 30e-6 / 60;  // m³/s

haptics::TissueVolume body(const char* solids) {
  return haptics::TissueVolume(haptics::read_solids(Json::parse(solids, "body")));
}
haptics::TissueVolume tooth() {
  return body(R"({"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [8, 8, 8], "center_mm": [0, 0, -4]}}},
    {"tissue": "pulp", "solid": {"box": {"size_mm": [3, 3, 3], "center_mm": [0, 0, -3.5]}}}]})");
}
haptics::TissueVolume bone() {
  return body(R"({"voxel_mm": 0.2, "solids": [
    {"tissue": "cortical_bone", "solid": {"box": {"size_mm": [8, 8, 8], "center_mm": [0, 0, -4]}}}]})");
}
haptics::Tool ball() {
  haptics::Tool tool;
  tool.diameter = tool.length = 1.4_mm;
  return tool;
}
HeatMeter meter(const haptics::TissueVolume& start, double coolant) {
  const haptics::Tool tool = ball();
  return {session::read_heat_constants(Json::load(assets_folder() / "materials" / "heat.json")),
          {coolant},
          kFlow,
          start,
          std::span(&tool, 1)};
}
/// A ball that turns in a pit of 0.5 mm.
std::vector<ServoTick> cutting(double power, double seconds) {
  std::vector<ServoTick> ticks(static_cast<std::size_t>(seconds * 1000));
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    ticks[i].t = from_seconds(1e-3 * static_cast<double>(i));
    ticks[i].X_WG.p = {0, 0, 0.2_mm};
    ticks[i].n_C_W = {0, 0, 1};
    ticks[i].spindle = 1000;
    ticks[i].cutting_power = power;
  }
  return ticks;
}

TEST(HeatMeter, ADryCutWarmsThePulpInProportionToItsWorkAndColdWaterCoolsIt) {
  const haptics::TissueVolume start = tooth();
  const auto pulp_after = [&](double power, double coolant, bool sprays) {
    HeatMeter heat = meter(start, coolant);
    heat.add(cutting(power, 20), sprays);
    return heat.pulp() - HeatMeter::kBody;
  };
  const double one = pulp_after(1, 37, false);
  EXPECT_GT(one, 0.1);
  EXPECT_NEAR(pulp_after(3, 37, false) / one, 3, 1e-6);
  EXPECT_EQ(pulp_after(0, 10, false), 0) << "no work, no water";
  EXPECT_LT(pulp_after(3, 10, true), -1);
  EXPECT_LT(pulp_after(3, 10, true), pulp_after(3, 30, true));
  EXPECT_LT(pulp_after(3, 37, true), 3 * one) << "water of the body's temperature takes heat, too";
}

TEST(HeatMeter, GivesTheSameWhateverTheGroupsOfTicks) {
  const haptics::TissueVolume start = tooth();
  const std::vector<ServoTick> ticks = cutting(3, 3);
  HeatMeter whole = meter(start, 23), single = meter(start, 23);
  whole.add(ticks, true);
  for (const ServoTick& tick : ticks) single.add({&tick, 1}, true);
  EXPECT_EQ(whole.pulp(), single.pulp());
  EXPECT_EQ(whole.result().pulp_curve, single.result().pulp_curve);
  EXPECT_EQ(whole.result().pulp_curve.size(), 2U);
  EXPECT_FALSE(whole.result().bone);
}

TEST(HeatMeter, CountsTheSecondsThatBoneBesideACutIsTooHot) {
  HeatMeter heat = meter(bone(), 23);
  std::vector<ServoTick> ticks = cutting(60, 20);
  for (std::size_t i = 10000; i < ticks.size(); ++i) ticks[i].cutting_power = 0;
  heat.add(ticks, false);
  const session::HeatMeasures found = heat.result();
  EXPECT_TRUE(found.bone);
  EXPECT_FALSE(found.pulp);
  EXPECT_GT(found.bone_max, HeatMeter::kBoneHarm);
  EXPECT_GT(found.bone_above, 1);
  EXPECT_LT(found.bone_above, 20);
  EXPECT_LT(heat.bone(), found.bone_max) << "it cools afterwards";
}

}  // namespace
}  // namespace typodont
