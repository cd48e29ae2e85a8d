// Prints the rows of the benchmark. Checks only ratios of medians.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "engine/debris/bench.h"

namespace typodont::debris {
namespace {

TEST(DebrisBench, AHundredThousandParticlesTakeAtMostTwiceTheTimeOfTheirMemoryAccess) {
  // Uses the best of three runs, because other work on the machine can only make a run slower.
  std::vector<BenchRow> rows = bench_debris({});
  for (int i = 0; i < 2; ++i) {
    const std::vector<BenchRow> again = bench_debris({});
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (again[k].ratio < rows[k].ratio) rows[k] = again[k];
    }
  }
  for (const BenchRow& r : rows) {
    fmt::print("{:<20}{:<20}{:>10.2f} us  ratio {:.3f} of {}\n", r.name, r.knob, r.time_ns * 1e-3, r.ratio, r.baseline);
  }
  ASSERT_EQ(rows.size(), 9u);
  EXPECT_EQ(rows[1].name, "step");
  EXPECT_EQ(rows[3].name, "step with suction");
  EXPECT_LT(rows[1].ratio, 2);
  // ratio: 1.8 on an idle machine; it would be 4.1 if every particle in the air flow were updated
  EXPECT_LT(rows[3].ratio, 3);
  EXPECT_EQ(rows[4].name, "none alive");
  EXPECT_LT(rows[4].ratio, 0.03);
  for (std::size_t k = 5; k < rows.size(); ++k) {
    EXPECT_TRUE(rows[k].name.starts_with("spray of")) << rows[k].name;
    EXPECT_LT(rows[k].time_ns, 5e6) << "a sixth of a picture's time";
  }
}

}  // namespace
}  // namespace typodont::debris
