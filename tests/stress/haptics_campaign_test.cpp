// Seeded random campaigns on the worst shapes: nothing passes through, no energy from nothing, no drift. Short here;
// ./run stress makes them long.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "engine/base/units.h"
#include "tests/support/campaign.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using haptics::ServoSettings;
using test::campaign;
using test::HapticBench;

struct Worst {
  const char* name;
  const char* tissue;
};

constexpr Worst kWorst[] = {
    {"a sheet of a tenth of a millimetre",
     R"({"voxel_mm": 0.1, "band_mm": 0.8, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [5, 5, 0.1]}}}]})"},
    {"a V-groove of 40 degrees", R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"difference": [
      {"box": {"size_mm": [5, 5, 3]}}, {"intersection": [{"box": {"size_mm": [6, 6, 6]}},
      {"halfspace": {"normal": [0.94, 0, -0.342], "offset_mm": 0}}, {"halfspace": {"normal": [-0.94, 0, -0.342], "offset_mm": 0}}]}]}}]})"},
    {"two balls that touch", R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"center_mm": [-1.5, 0, 0], "radius_mm": 1.5}}},
      {"tissue": "dentin", "solid": {"sphere": {"center_mm": [1.5, 0, 0], "radius_mm": 1.5}}}]})"},
    {"a tunnel hardly wider than the head",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
      {"box": {"size_mm": [4, 4, 4]}}, {"cylinder": {"axis": [0, 0, 1], "radius_mm": 0.55, "height_mm": 9}}]}}]})"},
    {"a pin thinner than three voxels",
     R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"cylinder": {"axis": [0, 0, 1], "radius_mm": 0.13, "height_mm": 4}}}]})"}};

/// A hand that wanders like a person's, at up to `speed` m/s, near the body.
class Wanderer {
 public:
  Wanderer(std::uint32_t seed, double speed) : random_(seed), speed_(speed) {}
  dvec3 next(double dt) {
    const auto push = [&] { return normal_(random_); };
    v_ += std::sqrt(dt) * 3.0 * speed_ * dvec3(push(), push(), push()) - dt * (6.0 * v_ + 40.0 * p_);
    if (const double length = glm::length(v_); length > speed_) v_ *= speed_ / length;
    return p_ += dt * v_;
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0, 1};
  double speed_;
  dvec3 p_{0, 0, 3.0_mm}, v_{0};
};

TEST(Campaign, OnTheWorstShapesForcesStayBoundedAndAProbingHandGetsNoEnergy) {
  for (const Worst& worst : kWorst) {
    for (const double speed : {0.02, 0.1, 0.4}) {
      ServoSettings s;
      s.tool.diameter = s.tool.length = 1.0_mm;
      s.cutting = false;
      HapticBench bench(worst.tissue, s);
      Wanderer hand(static_cast<std::uint32_t>(1000 * speed), speed);
      for (int i = 0; i < campaign(2500); ++i) {
        const ServoTick& tick = bench.tick({hand.next(1e-3)});
        ASSERT_TRUE(is_finite(tick.f_T_W) && is_finite(tick.X_WG.p)) << worst.name << ", tick " << i;
        ASSERT_LE(glm::length(tick.f_T_W), s.force_limit * (1 + 1e-9)) << worst.name << ", tick " << i;
        ASSERT_GE(tick.energy, -1e-9) << worst.name << ", tick " << i << ", " << speed << " m/s";
      }
    }
  }
}

TEST(Campaign, DrillingTheWorstShapesKeepsForcesBoundedAndTheSpindlesShareBelowItsWork) {
  for (const Worst& worst : kWorst) {
    ServoSettings s;
    s.tool.diameter = s.tool.length = 1.0_mm;
    s.spindle.free_speed = 200.0_krpm;
    HapticBench bench(worst.tissue, s);
    Wanderer hand(7, 0.03);
    double work = 0;
    for (int i = 0; i < campaign(2500); ++i) {
      const ServoTick& tick = bench.tick({hand.next(1e-3)}, 1);
      ASSERT_TRUE(is_finite(tick.f_T_W) && is_finite(tick.X_WG.p)) << worst.name << ", tick " << i;
      ASSERT_LE(glm::length(tick.f_T_W), s.force_limit * (1 + 1e-9)) << worst.name << ", tick " << i;
      work += tick.cutting_power * 1e-3;
      ASSERT_LE(tick.spindle_energy, work + 1e-7) << worst.name << ", tick " << i;
    }
  }
}

TEST(Campaign, AfterAnyNumberOfCutsTheFieldIsStillTheUnionOfTheirBalls) {
  // Where only balls were taken from a block far inside, the field is the deepest of them, to the float's last digits.
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

TEST(Campaign, AfterAnyNumberOfCutsAndFillingsInAnyOrderPatchAndVolumeHoldTheSameBitsAndNothingIsLost) {
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
  // A box of the volume as the servo holds it: dense, cut and filled by the same functions.
  haptics::SurfacePatch patch;
  patch.resize(65);
  patch.lo = glm::ivec3(glm::round(frame.to_voxels(dvec3(0)))) - 32;
  volume.copy_for_patch(patch.lo, glm::ivec3(65), patch.distance.data(), patch.tissue.data());
  PerTissue removed{}, added{};
  dvec3 at(0);
  for (int i = 0; i < campaign(2000); ++i) {
    const dvec3 next = glm::clamp(at + 0.2_mm * dvec3(uniform(random), uniform(random), uniform(random)), -1.5_mm, 1.5_mm);
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
  // What was put down less what was taken is what is there: tissue by tissue, however often it changed hands.
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
