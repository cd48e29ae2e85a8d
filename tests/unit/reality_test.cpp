// Published experiments that set no constant (role "test"), in the ranges of docs/reality.md.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bench/reality/experiments.h"

namespace typodont::bench {
namespace {

class Reality : public testing::TestWithParam<const char*> {};

TEST_P(Reality, AgreesWithAnExperimentThatSetNoConstant) {
  const std::vector<Experiment> all = experiments();
  const auto found = std::find_if(all.begin(), all.end(), [](const Experiment& e) { return e.id == GetParam(); });
  ASSERT_NE(found, all.end());
  ASSERT_EQ(found->role, "test");
  EXPECT_TRUE(agrees(*found));
}

INSTANTIATE_TEST_SUITE_P(Rows, Reality,
                         testing::Values("enamel_diamond_bovine", "dentin_above_enamel", "macor_grit",
                                         "macor_medium_below", "macor_coarse_rises", "leucite_ratio_heavy",
                                         "macor_carbide_coarse", "macor_diamond", "femur_thrust_1250",
                                         "femur_torque_1250", "femur_feed_1000", "artificial_thrust_1000",
                                         "artificial_torque_1000", "artificial_thrust_1500", "artificial_torque_1500",
                                         "bone_small_chips", "bovine_thrust_exponent", "electric_power",
                                         "pulp_water_23", "pulp_water_35", "implant_undersized", "wear_coarse"),
                         [](const auto& param) { return std::string(param.param); });

}  // namespace
}  // namespace typodont::bench
