// Prints the rows of the benchmark. Checks only what must hold on any machine: ratios, never times.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "calibration/bench.h"

namespace typodont::calibration {
namespace {

TEST(CalibrationBench, TypodontIsNeverSlowerThanEigenOrOpenCvAtEqualError) {
  const auto rows = bench_rows();
  for (const BenchRow& row : rows) {
    fmt::print("{:60} {:6} {:10.5f} {:22} {:12.2f} us\n", row.name, row.size, row.error, row.error_unit,
               row.time_ns * 1e-3);
  }
  int compared = 0;
  for (const BenchRow& ours : rows) {
    const std::size_t comma = ours.name.find(", typodont");
    const std::string task = ours.name.substr(0, comma);
    if (comma == std::string::npos || ours.name.ends_with("noise estimated") ||
        (!task.starts_with("register") && task != "camera"))
      continue;
    for (const BenchRow& theirs : rows) {
      const bool other = theirs.name.starts_with(task + ", Eigen") || theirs.name.starts_with(task + ", OpenCV");
      if (!other || theirs.size != ours.size) continue;
      ++compared;
      EXPECT_LE(ours.time_ns, theirs.time_ns) << ours.name << ", " << theirs.name << " " << ours.size;
      EXPECT_LE(ours.error, theirs.error * 1.001) << ours.name << ", " << theirs.name << " " << ours.size;
    }
  }
  EXPECT_GE(compared, 7);
}

}  // namespace
}  // namespace typodont::calibration
