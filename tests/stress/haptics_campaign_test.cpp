// Random campaigns of cuts and fillings from seeds: there is no drift, and no volume is lost. The normal run is short;
// ./run stress makes it long.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "engine/base/units.h"
#include "haptics/cutting/carve.h"
#include "tests/support/campaign.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using test::campaign;

TEST(Campaign, AfterAnyNumberOfCutsTheFieldIsStillTheUnionOfTheirBalls) {
  // If only balls are removed from a block far below its surface, the field is the largest of their distances, up to
  // the last digits of a float.
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 6]}}}]})";
  const haptics::DenseTissue dense = haptics::read_solids(Json::parse(kBlock, "tissue"));
  haptics::TissueVolume volume(dense);
  const double h = dense.frame.voxel;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  haptics::Tool tool;
  struct Ball {
    dvec3 c;
    double r;
  };
  std::vector<Ball> balls;
  for (int i = 0; i < campaign(3000); ++i) {
    balls.push_back(
        {1.6_mm * dvec3(uniform(random), uniform(random), uniform(random)), 0.25_mm + 0.15_mm * uniform(random)});
    tool.diameter = tool.length = 2 * balls.back().r;
    const Pose at{balls.back().c};
    volume.carve(haptics::Sweep(tool, at, at, dense.frame));
  }
  const int half = static_cast<int>(2.1_mm / h);
  const dvec3 middle = dense.frame.to_voxels(dvec3(0));
  int near = 0;
  for (int k = 0; k < 4000; ++k) {
    const glm::ivec3 v =
        glm::ivec3(glm::round(middle)) +
        glm::ivec3(glm::round(static_cast<double>(half) * dvec3(uniform(random), uniform(random), uniform(random))));
    float distance = 0;
    Tissue label = Tissue::kAir;
    volume.copy(v, glm::ivec3(1), &distance, &label);
    const dvec3 p = dense.frame.to_world(dvec3(v));
    double deepest = -1e9;
    for (const Ball& b : balls) deepest = std::max(deepest, b.r - glm::length(p - b.c));
    if (std::abs(deepest) > 2 * h) continue;  // beyond what a cut keeps exact
    ++near;
    ASSERT_NEAR(distance, deepest / h, 2e-3) << k;  // voxels
  }
  EXPECT_GT(near, 50);
}

TEST(Campaign, AfterRandomCutsAndFillingsPatchAndVolumeHaveTheSameBits) {
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [5, 5, 5]}}}]})";
  haptics::TissueVolume volume(haptics::read_solids(Json::parse(kBlock, "tissue")));
  const VoxelFrame frame = volume.frame();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  haptics::Tool bur, plugger;
  plugger.cuts = false;
  plugger.fill = Tissue::kAmalgam;
  const PerTissue before = volume.volumes();
  // A patch: a box of the volume as the servo holds it. It is dense, and it is cut and filled by the same functions.
  haptics::TissuePatch patch;
  patch.resize(65);
  patch.lo = glm::ivec3(glm::round(frame.to_voxels(dvec3(0)))) - 32;
  volume.copy_for_patch(patch.lo, glm::ivec3(65), patch.distance.data(), patch.tissue.data());
  PerTissue removed{}, added{};
  dvec3 at(0);
  for (int i = 0; i < campaign(10000); ++i) {  // ./run stress: a million
    const dvec3 next =
        glm::clamp(at + 0.2_mm * dvec3(uniform(random), uniform(random), uniform(random)), -1.5_mm, 1.5_mm);
    const double radius = 0.4_mm + 0.2_mm * uniform(random);
    if (random() % 2) {
      bur.diameter = bur.length = 2 * radius;
      const haptics::Sweep sweep(bur, Pose{at}, Pose{next}, frame);
      volume.carve(sweep);
      const PerTissue took = haptics::carve(patch, sweep);
      for (std::size_t t = 0; t < took.size(); ++t) removed[t] += took[t];
    } else {
      plugger.diameter = plugger.length = 0.6_mm;
      const haptics::Fill fill(plugger, next, radius, Pose{next + dvec3(0, 0, radius)}, frame);
      volume.fill(fill);
      bool changed;
      const PerTissue put = haptics::fill(patch, fill, &changed);
      for (std::size_t t = 0; t < put.size(); ++t) added[t] += put[t];
    }
    at = next;
  }
  std::vector<float> kept(patch.distance.size());
  std::vector<Tissue> kept_label(patch.tissue.size());
  volume.copy_for_patch(patch.lo, glm::ivec3(65), kept.data(), kept_label.data());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ASSERT_EQ(kept[i], patch.distance[i]) << i;
    ASSERT_EQ(kept_label[i], patch.tissue[i]) << i;
    ASSERT_TRUE(std::isfinite(kept[i]));
  }
  // For each tissue, the volume at the end must equal the volume at the start plus what was put down minus what was
  // removed.
  const PerTissue after = volume.volumes();
  const double voxel3 = std::pow(frame.voxel, 3);
  double all_before = 0, all_after = 0, all_moved = 0, turnover = 0;
  for (std::size_t t = 0; t < after.size(); ++t) {
    all_before += before[t], all_after += after[t], all_moved += (added[t] - removed[t]) * voxel3;
    turnover += (added[t] + removed[t]) * voxel3;
  }
  EXPECT_NEAR(all_after - all_before, all_moved, 1e-12 * (all_before + turnover));
  EXPECT_GT(added[static_cast<std::size_t>(Tissue::kAmalgam)], 1000);
  EXPECT_GT(removed[static_cast<std::size_t>(Tissue::kAmalgam)], 1000);
}

}  // namespace
}  // namespace typodont
