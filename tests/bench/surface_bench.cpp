// Prints the rows of `typodont bench surface` and checks ratios of medians.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "engine/app/bench/parts.h"

namespace typodont {
namespace {

const std::vector<BenchRow>& rows() {
  static const std::vector<BenchRow> measured = [] {
    std::vector<BenchRow> all = bench_surface({.quick = true});
    for (const auto& r : all)
      fmt::print("{:<44}{:<20}{:>9.3g} {:<42}{:>10.4g} ms per {:<13}{:>9.0f} triangles  ratio {:.4f} to {}\n", r.name,
                 r.knob, r.error, r.error_unit, r.time_ns * 1e-6, r.per, r.size, r.ratio, r.baseline);
    return all;
  }();
  return measured;
}

/// Returns the number of rows with this name. Fails for each of them whose ratio is not below `most`.
int rows_below(const std::string& name, double most) {
  int found = 0;
  for (const BenchRow& row : rows()) {
    if (row.name != name) continue;
    ++found;
    EXPECT_LT(row.ratio, most) << row.knob;
  }
  return found;
}

TEST(SurfaceBench, ASphereNeedsFewTrianglesForItsError) {
  int found = 0;
  for (const BenchRow& row : rows()) {
    if (row.name != "sphere") continue;
    ++found;
    EXPECT_LT(row.error, 7.3) << row.knob;
  }
  EXPECT_GT(found, 3);
}

TEST(SurfaceBench, ADrillingFrameOnTheMolarIsFiftyTimesFasterThanMeshingTheWholeMolar) {
  EXPECT_EQ(rows_below("molar at 0.05 mm, drilling frame, triangles", 1.0 / 50), 2);
}

TEST(SurfaceBench, MeshingAWholeVolumeIsThreeTimesFasterThanVolumeToMeshAtEqualError) {
  EXPECT_EQ(rows_below("ball at equal error, whole, triangles", 1.0 / 3), 1);
}

}  // namespace
}  // namespace typodont
