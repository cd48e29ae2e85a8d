// Measures the time that the code of the devices adds to a tick. Prints the rows of `typodont bench devices` and checks
// their limits.
#include "haptics/device_bench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace typodont::haptics {
namespace {

TEST(DeviceBench, AnArmsTickTakesLessThan50MicrosecondsAndVelocityHasLessNoiseThanADifference) {
  const std::vector<BenchRow> rows = bench_devices({.ticks = 50'000, .assets = "assets"});
  double estimate = 0;
  int arms = 0, motions = 0;
  for (const BenchRow& r : rows) {
    fmt::print("{:<64}{:<20}{:>12.4g} {:<10}{:>12.4g} ns{:>10.3g}\n", r.name, r.knob, r.error, r.error_unit, r.time_ns,
               r.ratio);
    if (r.name.find("limits and currents, median") != std::string::npos) {
      EXPECT_LT(r.time_ns, 50e3) << r.knob;
      ++arms;
    }
    if (r.name.ends_with(": estimate, at its stated lag")) estimate = r.error;
    if (r.name.ends_with(": difference of two samples")) {
      EXPECT_LT(estimate, 0.5 * r.error + 0.1) << r.name << r.knob;
      ++motions;
    }
  }
  EXPECT_EQ(arms, 5);
  EXPECT_EQ(motions, 8);
}

}  // namespace
}  // namespace typodont::haptics
