// Prints the rows; what must hold in any environment (a ratio, never a time) is tested.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/bench.h"

namespace typodont::calibration {
namespace {

TEST(CalibrationBench, OursIsNeverSlowerAtEqualErrorThanEigenOrOpenCv) {
  const auto rows = bench_rows();
  for (const BenchRow& row : rows) {
    fmt::print("{:24} {:36} {:6} {:10.5f} {:22} {:12.2f} us\n", row.task, row.method, row.touches, row.error, row.error_unit, row.time_us);
  }
  for (const BenchRow& ours : rows) {
    if (ours.task != "register" || ours.method != "typodont") continue;
    for (const BenchRow& theirs : rows) {
      if (theirs.task != ours.task || theirs.touches != ours.touches || theirs.method == ours.method) continue;
      EXPECT_LE(ours.time_us, theirs.time_us) << theirs.method << " " << ours.touches;
      EXPECT_LE(ours.error, theirs.error * 1.001) << theirs.method << " " << ours.touches;
    }
  }
}

}  // namespace
}  // namespace typodont::calibration
