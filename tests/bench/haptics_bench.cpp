// Checks the errors in the benchmark rows of the haptics. Times are printed and not checked.
#include <gtest/gtest.h>

#include <string_view>
#include <vector>

#include "haptics/bench.h"

namespace typodont {
namespace {

const std::vector<BenchRow>& rows() {
  static const auto all = [] {
    haptics::BenchOptions options;
    options.ticks = 300;
    options.voxels_mm = {0.2, 0.1};
    return haptics::bench_contact(options);
  }();
  return all;
}

const BenchRow& row(std::string_view name, std::string_view knob) {
  for (const auto& r : rows()) {
    if (r.name == name && r.knob == knob) return r;
  }
  ADD_FAILURE() << "no row " << name << ", " << knob;
  return rows().front();
}

TEST(HapticsBench, EveryRowHasATime) {
  for (const auto& r : rows()) EXPECT_GT(r.time_ns, 0) << r.name;
}

TEST(HapticsBench, TheProxysDirectionErrorIsFourOrdersOfMagnitudeBelowVoxelPenalty) {
  EXPECT_LT(row("slide on a sphere, median", "voxel 0.1 mm").error,
            1e-4 * row("slide on a sphere, voxel penalty", "voxel 0.1 mm").error);
}

TEST(HapticsBench, CubicInterpolationHasAThousandthOfTheDirectionErrorOfTrilinear) {
  EXPECT_LT(row("direction, cubic", "voxel 0.1 mm").error, 1e-3 * row("direction, trilinear", "voxel 0.1 mm").error);
}

TEST(HapticsBench, TheSpentEnergyEqualsTheEnergyOfTheRemovedVolume) {
  for (const char* knob : {"round 1.2 mm, voxel 0.1 mm", "round 4 mm, voxel 0.1 mm", "flame 1.2 x 4 mm, voxel 0.1 mm",
                           "cylinder 1 x 4 mm, voxel 0.1 mm"}) {
    EXPECT_LT(row("drilling tick, median", knob).error, 1e-6);
  }
}

TEST(HapticsBench, ASweepHasNoMoreErrorThanALevelSetDifference) {
  EXPECT_LT(row("removal, sweep", "voxel 0.1 mm").error, row("removal, OpenVDB csgDifference", "voxel 0.1 mm").error);
}

}  // namespace
}  // namespace typodont
