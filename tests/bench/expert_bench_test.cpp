// Measures the simulated expert's score and time in every shipped exercise that it can do.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/expert_session.h"

namespace typodont {
namespace {

struct Expected {
  const char* scene;
  double percent, seconds;
};

class ExpertBench : public testing::TestWithParam<Expected> {};

TEST_P(ExpertBench, ScoresAndEndsInTime) {
  const Expected& expected = GetParam();
  const test::ExpertResult result = test::expert_session(expected.scene, 1200);
  fmt::print("{}: {:.1f} of 100 points in {:.1f} s\n", expected.scene, result.percent, result.seconds);
  EXPECT_GE(result.percent, expected.percent) << result.items;
  EXPECT_LT(result.seconds, expected.seconds);
  if (std::string(expected.scene) == "crown-preparation") {  // loads on walls and occlusal surface, docs/reality.md
    EXPECT_NEAR(result.drill.side_force(), 1.71, 0.2);
    EXPECT_NEAR(result.drill.end_force(), 0.45, 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, ExpertBench,
                         testing::Values(Expected{"tutorial", 95, 300}, Expected{"molar-caries", 95, 300},
                                         Expected{"remove-caries", 95, 300}, Expected{"class-1-cavity", 95, 300},
                                         Expected{"class-2-cavity", 95, 400}, Expected{"amalgam-filling", 95, 120},
                                         Expected{"root-canal-access", 95, 400},
                                         Expected{"crown-preparation", 95, 1000},
                                         Expected{"root-canal-access-packing", 95, 300},
                                         Expected{"acetabular-reaming", 95, 120}, Expected{"implant-molar", 95, 120},
                                         Expected{"implant-molar-soft", 95, 120}, Expected{"implant-premolar", 95, 120},
                                         Expected{"implant-front", 95, 120}),
                         [](const auto& param) {
                           std::string name = param.param.scene;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace typodont
