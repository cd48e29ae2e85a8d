// Tests every contact model with hands that move as no human hand can, and with invalid input. The output is finite and
// bounded, removed volume never decreases, and bad input gives zero force. The normal run is short; ./run stress tests
// millions of ticks. docs/stress.md states the energy that such hands get from each model.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "engine/base/units.h"
#include "haptics/contact_method.h"
#include "tests/support/campaign.h"
#include "tests/support/hostile_hand.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using namespace test;

struct Body {
  const char* name;
  const char* tissue;
  double top;  // m: no tissue is higher
};
constexpr Body kBodies[] = {
    {"a ball", R"({"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})", 3.0_mm},
    {"a block", R"({"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [5, 5, 3]}}}]})",
     1.5_mm}};

constexpr const char* kIntermediate = "offset_with_intermediate_surface";

/// Returns settings with this model. Models that need long to start get smaller parameters than their defaults.
ServoSettings settings_of(const std::string& model) {
  haptics::Tool bur;
  bur.diameter = bur.length = 1.2_mm;
  ServoSettings settings = hostile_settings(bur);
  const std::string json = model == "packing"       ? R"({"packing": {"spheres": 2000}})"
                           : model == "mesh_lod"    ? R"({"mesh_lod": {"vertices": 2000, "levels": [2000, 800]}})"
                           : model == kIntermediate ? R"({"offset": {"intermediate_surface": {}}})"
                                                    : "\"" + model + "\"";
  settings.method = haptics::read_contact_method(Json::parse(json, "model"));
  return settings;
}

class HostileHandOnEveryModel : public testing::TestWithParam<std::string> {};

TEST_P(HostileHandOnEveryModel, GetsFiniteBoundedForcesAndZeroForInvalidInput) {
  int bad = 0;
  double felt = 0;
  for (const Body& body : kBodies) {
    SCOPED_TRACE(body.name);
    std::uint64_t seed = 1;
    for (int left = campaign(1500); left > 0; left -= kHostileRound, ++seed) {
      HapticBench bench(body.tissue, settings_of(GetParam()));
      ErraticHand hand(seed, {0, 0, body.top});
      InvalidInput nonsense(seed, {0, 0, body.top});
      std::uint64_t cuts = 0;
      for (int i = 0; i < std::min(left, kHostileRound); ++i) {
        Pose X = hand.next(1e-3);
        double pedal = nonsense.pedal();
        spoil(nonsense, /*undoes=*/true, bench, hand, X, pedal);
        const ServoTick& tick = bench.tick(X, pedal);
        ASSERT_NO_FATAL_FAILURE(expect_sense(tick)) << "seed " << seed << ", tick " << i;
        ASSERT_GE(tick.cuts, cuts) << "seed " << seed << ", tick " << i;
        cuts = tick.cuts;
        for (const double removed : tick.removed) ASSERT_GE(removed, -1e-15) << "seed " << seed << ", tick " << i;
        felt = std::max(felt, glm::length(tick.f_T_W));
        if (tick.faults & bits(Fault::kBadInput)) {
          ++bad;
          ASSERT_EQ(tick.f_T_W, dvec3(0)) << "seed " << seed << ", tick " << i;
        }
      }
    }
  }
  EXPECT_GT(bad, 0);
  EXPECT_GT(felt, 0.05);
}

std::vector<std::string> all_models() {
  std::vector<std::string> names = haptics::contact_method_names();
  names.push_back(kIntermediate);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Models, HostileHandOnEveryModel, testing::ValuesIn(all_models()),
                         [](const auto& model) { return model.param; });

}  // namespace
}  // namespace typodont
