// Tests hands that move as no human hand can, with every kind of head on the most difficult shapes. For any input, the
// output is finite, bounded and explained, and no hand gets energy that it did not put in. The normal run is short;
// ./run stress tests ten million ticks.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <string>

#include "engine/base/units.h"
#include "tests/support/campaign.h"
#include "tests/support/hostile_hand.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using namespace test;

struct Body {
  const char* name;
  const char* tissue;  // JSON, or a volume of assets/
  dvec3 top;           // m: no tissue is higher
};

/// The molar, and bodies in which the field's gradient jumps or which are thinner than a voxel.
constexpr Body kBodies[] = {
    {"the molar", "assets/teeth/molar.vdb", {6.8_mm, 5.5_mm, 20.5_mm}},
    {"a bored ball of two tissues",
     R"({"voxel_mm": 0.2, "solids": [
      {"tissue": "enamel", "solid": {"difference": [{"sphere": {"radius_mm": 4}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}},
      {"tissue": "dentin", "solid": {"difference": [{"sphere": {"radius_mm": 3}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}}]})",
     {0, 0, 4.0_mm}},
    {"a sheet of a tenth of a millimetre",
     R"({"voxel_mm": 0.1, "band_mm": 0.8, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [5, 5, 0.1]}}}]})",
     {0, 0, 0.05_mm}},
    {"a V-groove of 40 degrees",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"difference": [
      {"box": {"size_mm": [5, 5, 3]}}, {"intersection": [{"box": {"size_mm": [6, 6, 6]}},
      {"halfspace": {"normal": [0.94, 0, -0.342], "offset_mm": 0}}, {"halfspace": {"normal": [-0.94, 0, -0.342], "offset_mm": 0}}]}]}}]})",
     {0, 0, 1.5_mm}},
    {"spikes",
     R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -1.5], "size_mm": [5, 5, 1]}}},
      {"tissue": "enamel", "solid": {"union": [
        {"cone": {"center_mm": [-0.8, -0.8, 0], "axis": [0, 0, 1], "radius_mm": 0.4, "height_mm": 2}},
        {"cone": {"center_mm": [0.8, -0.8, 0], "axis": [0, 0, 1], "radius_mm": 0.2, "height_mm": 2}},
        {"cone": {"center_mm": [-0.8, 0.8, 0], "axis": [0.3, 0, 1], "radius_mm": 0.3, "height_mm": 2}},
        {"cylinder": {"center_mm": [0.8, 0.8, 0], "axis": [0, 0, 1], "radius_mm": 0.13, "height_mm": 2}}]}}]})",
     {0, 0, 1.0_mm}},
    {"a slot, its medial plane amid the heads",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
      {"box": {"size_mm": [5, 5, 3]}}, {"box": {"center_mm": [0, 0, 0.5], "size_mm": [1.3, 9, 3]}}]}}]})",
     {0, 0, 1.5_mm}},
    {"a tunnel hardly wider than the smaller heads",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
      {"box": {"size_mm": [4, 4, 4]}}, {"cylinder": {"axis": [0, 0, 1], "radius_mm": 0.55, "height_mm": 9}}]}}]})",
     {0, 0, 2.0_mm}},
    {"a ring about its medial axis",
     R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "enamel", "solid": {"torus": {"axis": [0, 0, 1], "major_mm": 1.4, "minor_mm": 0.6}}}]})",
     {0, 0, 0.6_mm}},
    {"two balls that touch",
     R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"center_mm": [-1.5, 0, 0], "radius_mm": 1.5}}},
      {"tissue": "dentin", "solid": {"sphere": {"center_mm": [1.5, 0, 0], "radius_mm": 1.5}}}]})",
     {0, 0, 1.5_mm}}};

haptics::TissueVolume volume_of(const Body& body) {
  const std::string tissue = body.tissue;
  if (tissue.ends_with(".vdb")) return haptics::TissueVolume::load(tissue);
  return haptics::TissueVolume(haptics::read_solids(Json::parse(tissue, body.name)));
}

class HostileHand : public testing::TestWithParam<const char*> {
 protected:
  static ServoSettings settings() {
    return hostile_settings(haptics::read_tool(Json::load(fmt::format("assets/tools/{}.json", GetParam()))));
  }
};

TEST_P(HostileHand, GainsNoEnergyOnTheWorstShapesBeyondTheSpindlesWork) {
  std::uint64_t seed = 1;
  double felt = 0;
  for (const Body& body : kBodies) {
    for (int left = campaign(600); left > 0; left -= kHostileRound, ++seed) {
      SCOPED_TRACE(fmt::format("{}, seed {}", body.name, seed));
      const ServoSettings s = settings();
      HapticBench bench(volume_of(body), s);
      ErraticHand hand(seed, body.top + dvec3(0, 0, haptics::near_reach(s.tool) + 0.2_mm));  // not born inside
      const bool drills = seed % 3 != 0;
      double work = 0;  // J, of the spindle
      for (int i = 0; i < std::min(left, kHostileRound); ++i) {
        // Moves down into the body and up again, so that the hand meets all of it.
        const Pose at = hand.next(1e-3);
        const dvec3 p = at.p - dvec3(0, 0, 1.5_mm * (1 - std::cos(2e-3 * kPi * i)));
        const ServoTick& tick = bench.tick({p, at.R}, drills ? 1 : 0);
        ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "tick " << i;
        ASSERT_GE(tick.energy, -1e-9) << "tick " << i;
        work += tick.cutting_power * 1e-3;
        ASSERT_LE(tick.spindle_energy, work + 1e-7) << "tick " << i;
        felt = std::max(felt, glm::length(tick.f_T_W));
      }
    }
  }
  EXPECT_GT(felt, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Heads, HostileHand,
                         testing::Values("round_012", "round_040", "flame_012", "cylinder_010",
                                         "round_end_cylinder_012", "end_guarded_cylinder_010", "cone_016", "pear_010",
                                         "inverted_cone_010", "excavator_spoon", "explorer"),
                         [](const auto& head) { return std::string(head.param); });

}  // namespace
}  // namespace typodont
