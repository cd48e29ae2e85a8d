// Tests the tangential force of a bur's teeth where the contact ends.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "engine/base/units.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;

/// Describes the force on the hand after a bur has left a wall of enamel at 50 mm/s. Before, the bur's side pressed on
/// the wall for half a second.
struct Leaving {
  double last_touch = 0;           // N, in the last tick of the contact
  std::vector<double> free_force;  // N, in the ticks after it
  double first_step = 0;           // N, from the last tick of the contact to the first free one
  double max_step = 0;             // N, between two free ticks
};

Leaving leave_wall(const char* model) {
  test::HapticBench bench(
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"box": {"center_mm": [3, 0, 0], "size_mm": [6, 8, 8]}}}]})",
      test::drill_settings(model));
  const double touch = -0.6_mm;  // x of the head's centre where it touches the wall
  double x = touch - 0.1_mm;
  for (int i = 0; i < 500; ++i) {
    x = std::min(x + 2e-6, std::max(x, bench.last.X_WG.p.x + 1.0_mm));  // 2 mm/s, at most 1 mm ahead of the bur
    bench.tick({{x, 0, 0}}, 1);
  }
  Leaving leaving;
  dvec3 last = bench.last.f_T_W;
  while (bench.last.depth > 0) {
    leaving.last_touch = glm::length(bench.last.f_T_W);
    last = bench.last.f_T_W;
    bench.tick({{x -= 50e-6, 0, 0}}, 1);
  }
  for (int i = 0; i < 100; ++i) {
    leaving.free_force.push_back(glm::length(bench.last.f_T_W));
    double& step = i == 0 ? leaving.first_step : leaving.max_step;
    step = std::max(step, glm::length(bench.last.f_T_W - last));
    last = bench.last.f_T_W;
    bench.tick({{x -= 50e-6, 0, 0}}, 1);
  }
  return leaving;
}

TEST(Teeth, ForceOfABurThatLeavesTheTissueFadesWithoutAStepAndThenIsZero) {
  for (const char* model : {"offset", "packing", "voxel_penalty"}) {
    const Leaving leaving = leave_wall(model);
    EXPECT_GT(leaving.free_force.front(), 0.02) << model;
    EXPECT_LT(leaving.first_step, 0.02 + 1e3 * 50e-6) << model;  // what the spring of 1 N/mm gives in that tick besides
    EXPECT_LT(leaving.max_step, 0.02) << model;
    EXPECT_EQ(leaving.free_force.back(), 0) << model;
  }
}

}  // namespace
}  // namespace typodont
