// Tests cutting: the volume for a given energy, and the geometry of the removed tissue.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <span>
#include <vector>

#include "engine/base/units.h"
#include "haptics/cutting/carve.h"
#include "haptics/cutting/cut_front.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/heads.h"
#include "tests/support/swinging_hand.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using haptics::Sweep;
using test::HapticBench;

ServoSettings drill(double diameter, double rate) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = diameter;
  s.tick = 1 / rate;
  s.spindle.free_speed = 300.0_krpm;
  return s;
}

std::string box(double voxel_mm) {
  char text[200];
  std::snprintf(text, sizeof text,
                R"({"voxel_mm": %g, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [5,5,5]}}}]})",
                voxel_mm);
  return text;
}

/// A hand pushes straight down for a second, and may swing sideways.
test::Drilled push(double voxel_mm, double rate, double newton, double swing = 1.0_mm) {
  HapticBench bench(box(voxel_mm), drill(1.2_mm, rate));
  const int second = static_cast<int>(rate);
  return test::drill(bench, {{0, 0, 3.12_mm}, newton, swing}, second, second / 10,
                     [](const ServoTick& tick, double) { EXPECT_EQ(tick.faults, 0u); });
}

TEST(Cutting, ABurOfThreeVoxelsRadiusSinksAsFastAsAWellResolvedOne) {
  const double fine = push(0.1, 1000, 1, 0).volume;
  for (const double rate : {500.0, 1000.0, 4000.0}) EXPECT_NEAR(push(0.2, rate, 1, 0).volume / fine, 1, 0.02) << rate;
}

TEST(Cutting, VolumeIsProportionalToForceWithinOnePercent) {
  const double one = push(0.1, 1000, 1, 0).volume;
  for (const double newton : {0.5, 2.0, 3.0})
    EXPECT_NEAR(push(0.1, 1000, newton, 0).volume / newton / one, 1, 0.01) << newton;
}

TEST(Cutting, WithoutPowerTheContactIsRigidAndWithoutResistanceTheBurMovesFreely) {
  const auto press = [](double pedal, double specific_energy) {
    MaterialTable materials = test::plain_materials();
    materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy = specific_energy;
    const Json tissue = Json::parse(box(0.1), "tissue");
    HapticBench bench(haptics::TissueVolume(haptics::read_solids(tissue)), drill(1.2_mm, 1000), materials);
    for (int i = 0; i < 200; ++i) bench.tick({{0, 0, 3.2_mm - i * 10.0_um}}, pedal);  // 10 mm/s, ends 1.9 mm deep
    return bench.last;
  };
  const double surface = 2.5_mm + 0.6_mm;
  const ServoTick rigid = press(0, 8e9), free = press(1, 1e3);
  EXPECT_NEAR(rigid.X_WG.p.z, surface, 1e-9);
  EXPECT_LT(free.depth, 10.001_um) << "more than the hand's motion in a tick";
}

/// A random head that is not a ball, and its poses before and after a motion of 1 to 50 voxels of 0.1 mm, with or
/// without rotation.
struct RandomWay {
  std::mt19937_64 random;
  haptics::Tool tool;
  Pose from, to;
  double turn;

  RandomWay(haptics::HeadShape shape, unsigned seed) : random(seed) {
    tool.shape = shape;
    tool.diameter = uniform(0.8_mm, 1.6_mm);
    tool.length = tool.diameter * (shape == haptics::HeadShape::kInvertedCone ? uniform(0.8, 1.2) : uniform(1.6, 2.5));
    const dvec3 half = 0.05_mm * std::exp(uniform(0, std::log(50.0))) * direction();
    const dvec3 middle(uniform(-0.3_mm, 0.3_mm), uniform(-0.3_mm, 0.3_mm), uniform(-0.3_mm, 0.3_mm));
    turn = std::max(0.0, uniform(-0.1, 0.1));
    from = {middle - half, rotation_between({0, 0, 1}, direction())};
    to = {middle + half, glm::normalize(glm::angleAxis(turn, direction()) * from.R)};
  }
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); }
  dvec3 direction() { return glm::normalize(dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1))); }
};

TEST(Carving, ALongSweepOfAnyHeadRemovesWhatShortOnesOfATwoHundredthVoxelDo) {
  HapticBench bench(
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [13, 13, 13]}}}]})",
      drill(1.2_mm, 1000));
  haptics::TissuePatch solid;
  solid.resize(121);
  bench.carver.take_snapshot({0, 0, 0}, solid);
  const VoxelFrame& frame = bench.settings.frame;
  for (const haptics::HeadShape shape : test::shapes_but_the_ball()) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const RandomWay way(shape, seed);
      haptics::TissuePatch at_once = solid;
      carve(at_once, Sweep(way.tool, way.from, way.from, frame));
      haptics::TissuePatch by_steps = at_once;
      const double whole = total(carve(at_once, Sweep(way.tool, way.from, way.to, frame, true)));
      haptics::CutFront front(std::span(&way.tool, 1), frame.voxel);
      const int steps =
          static_cast<int>(std::ceil((glm::length(way.to.p - way.from.p) + way.turn * way.tool.reach()) / 0.5_um));
      double sum = 0;
      Pose last = way.from;
      for (int i = 1; i <= steps; ++i) {
        const Pose next = i == steps ? way.to : interpolate(way.from, way.to, static_cast<double>(i) / steps);
        sum += total(carve(by_steps, Sweep(way.tool, last, next, frame, true), nullptr, &front));
        last = next;
      }
      EXPECT_NEAR(sum / whole, 1, 2e-4) << static_cast<int>(shape) << ", seed " << seed << ", voxels³ " << whole;
    }
  }
}

TEST(Carving, SweepsRemoveTheSameInAnyOrderAndGivePatchAndVolumeTheSameBits) {
  const haptics::DenseTissue block = haptics::read_solids(Json::parse(box(0.1), "tissue"));
  for (const haptics::HeadShape shape : test::head_shapes()) {
    std::vector<Sweep> sweeps;
    for (unsigned seed = 11; seed <= 14; ++seed) {
      RandomWay way(shape, seed);
      if (shape == haptics::HeadShape::kSphere) way.tool.length = way.tool.diameter;
      if (seed % 2 == 0) way.to.p = glm::mix(way.from.p, way.to.p, 0.02);  // long and short ways
      const dvec3 up(0, 0, 2.0_mm);                                        // through the surface
      sweeps.emplace_back(way.tool, Pose{way.from.p + up, way.from.R}, Pose{way.to.p + up, way.to.R}, block.frame);
    }
    haptics::TissueVolume volume(block);
    haptics::TissuePatch patch;
    patch.resize(101);
    patch.lo = glm::ivec3(glm::floor(block.frame.to_voxels({0, 0, 2.0_mm}))) - 50;
    volume.copy(patch.lo, glm::ivec3(patch.n), patch.distance.data(), patch.tissue.data());
    haptics::TissuePatch backwards = patch;
    double taken = 0, taken_backwards = 0;
    for (const Sweep& sweep : sweeps) {
      taken += total(carve(patch, sweep));
      volume.carve(sweep);
    }
    for (auto sweep = sweeps.rbegin(); sweep != sweeps.rend(); ++sweep)
      taken_backwards += total(carve(backwards, *sweep));
    ASSERT_EQ(patch.distance, backwards.distance) << static_cast<int>(shape);
    EXPECT_EQ(taken, taken_backwards) << static_cast<int>(shape);
    EXPECT_GT(taken, 100) << static_cast<int>(shape);

    const auto once = patch.distance;
    volume.copy(patch.lo, glm::ivec3(patch.n), backwards.distance.data(), backwards.tissue.data());
    std::size_t different = 0;  // near the surface: far from it the volume keeps less
    for (std::size_t i = 0; i < once.size(); ++i)
      different += std::abs(once[i]) < 2.9f && once[i] != backwards.distance[i];
    EXPECT_EQ(different, 0u) << static_cast<int>(shape);
    for (const Sweep& sweep : sweeps) {
      bool changed;
      EXPECT_EQ(total(carve(patch, sweep, &changed)), 0) << static_cast<int>(shape);
      EXPECT_FALSE(changed) << static_cast<int>(shape);
    }
    ASSERT_EQ(patch.distance, once) << static_cast<int>(shape);
  }
}

/// Moves a head along a path in short steps, each of which continues the previous one. The tissue must be the same as
/// after single cuts at all poses of the path.
void expect_short_steps_leave_what_all_poses_do(const haptics::Tool& tool, double turn) {
  HapticBench bench(box(0.1), [&] {
    ServoSettings s = drill(1.2_mm, 1000);
    s.tool = tool;
    return s;
  }());
  haptics::TissuePatch steps;
  steps.resize(91);
  bench.carver.take_snapshot({0, 0, 2.5_mm}, steps);
  haptics::TissuePatch poses = steps;
  const auto at = [&](int i) {
    const double t = i * 2e-6, a = turn * i;
    return Pose{dvec3(-0.3_mm + t, 0.1_mm + 0.4 * t * std::sin(0.05 * i), 2.5_mm + tool.reach() - 0.2_mm - 0.7 * t),
                glm::dquat(std::cos(a), std::sin(a), 0, 0)};
  };
  carve(steps, Sweep(tool, at(0), at(0), bench.settings.frame));
  carve(poses, Sweep(tool, at(0), at(0), bench.settings.frame));
  double by_steps = 0, by_poses = 0;
  constexpr int kPoses = 20;  // of a step
  for (int i = 1; i <= 300; ++i) {
    by_steps += total(carve(steps, Sweep(tool, at(i - 1), at(i), bench.settings.frame, true)));
    for (int k = 1; k <= kPoses; ++k) {
      const Pose pose = k == kPoses ? at(i) : interpolate(at(i - 1), at(i), static_cast<double>(k) / kPoses);
      by_poses += total(carve(poses, Sweep(tool, pose, pose, bench.settings.frame)));
    }
  }
  double worst = 0;
  for (std::size_t i = 0; i < steps.distance.size(); ++i) {
    worst = std::max(worst, static_cast<double>(std::abs(steps.distance[i] - poses.distance[i])));
  }
  EXPECT_LT(worst, 0.02) << static_cast<int>(tool.shape);  // voxels
  EXPECT_GT(by_steps, 20);
  EXPECT_NEAR(by_steps / by_poses, 1, 5e-4) << static_cast<int>(tool.shape);
}

TEST(Carving, ConsecutiveShortStepsEqualTheUnionOfTheirPosesForEveryHead) {
  using haptics::HeadShape;
  for (const HeadShape shape : test::head_shapes()) {
    haptics::Tool tool;
    tool.shape = shape;
    tool.diameter = 1.2_mm;
    tool.length = shape == HeadShape::kSphere ? 1.2_mm : 3.0_mm;
    for (const double turn : {0.0, 2e-4}) expect_short_steps_leave_what_all_poses_do(tool, turn);
  }
}

TEST(Carving, SkippedLeavesWouldNotHaveChanged) {
  // Compares with a copy that is made before each sweep. The copy does not know which leaves can be skipped, so it
  // looks at all of them.
  constexpr const char* kSmall =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [2.4, 2.4, 1.8]}}}]})";
  const haptics::DenseTissue block = haptics::read_solids(Json::parse(kSmall, "tissue"));
  for (const haptics::HeadShape head : test::head_shapes()) {
    haptics::Tool tool;
    tool.shape = head;
    tool.diameter = 1.1_mm;
    tool.length = head == haptics::HeadShape::kSphere ? 1.1_mm : 2.3_mm;
    haptics::TissueVolume kept(block), anew = kept.clone();
    const std::uint64_t uncut = kept.hash();
    Pose X{{0, 0, 0.91_mm + tool.length / 2}, glm::normalize(dquat(1, 0.1, 0.2, 0))};
    for (int i = 0; i < 120; ++i) {
      const auto wobble = [&](double rate) { return std::sin(rate * i + static_cast<int>(head)); };
      // The head moves into the block and out of it in tiny and large steps. Some steps do not continue the previous
      // sweep, and sometimes the other head cuts in between.
      const double step = i / 20 % 4 == 3 ? 40.0_um : i / 20 % 4 == 2 ? 0.1_um : 4.0_um;
      const dvec3 v = glm::normalize(dvec3(wobble(1.3), wobble(2.1), (i < 90 ? -2 : 2) + wobble(3.7)));
      const dquat turn(1, 1e-3 * wobble(0.7), 1e-3 * wobble(1.9), 1e-3 * wobble(2.9));
      const Pose Y{X.p + step * v, i / 30 % 2 ? glm::normalize(X.R * turn) : X.R};
      haptics::Tool with = tool;
      if (i % 53 == 52) with.diameter = 0.8_mm;
      const Sweep sweep(with, X, Y, block.frame, i % 37 != 0 && i % 53 != 52 && i % 53 != 0);
      anew = anew.clone();
      const haptics::TissueVolume::Carved a = kept.carve(sweep), b = anew.carve(sweep);
      ASSERT_EQ(a.box.lo, b.box.lo) << static_cast<int>(head) << ", sweep " << i;
      ASSERT_EQ(a.box.hi, b.box.hi) << static_cast<int>(head) << ", sweep " << i;
      if (i % 5 == 4) {
        ASSERT_EQ(kept.hash(), anew.hash()) << static_cast<int>(head) << ", sweep " << i;
      }
      X = Y;
    }
    EXPECT_NE(kept.hash(), uncut);
  }
}

TEST(Carving, TheVolumeErrorOfACapIsOfSecondOrderInTheVoxelSize) {
  const auto error = [](double voxel_mm) {
    HapticBench bench(box(voxel_mm), drill(1.2_mm, 1000));
    haptics::TissuePatch patch;
    patch.resize(static_cast<int>(4 / voxel_mm) + 1);
    bench.carver.take_snapshot({0, 0, 2.5_mm}, patch);
    const double depth = 0.45_mm, r = 0.6_mm, exact = kPi * depth * depth * (r - depth / 3);
    const dvec3 c(0.013_mm, 0.027_mm, 2.5_mm + r - depth);
    const double h = voxel_mm * 1e-3;
    return std::abs(
        total(carve(patch, Sweep(bench.settings.tool, {c}, {c}, bench.settings.frame))) * h * h * h / exact - 1);
  };
  const double coarse = error(0.1), fine = error(0.05);
  EXPECT_LT(coarse, 0.01);
  EXPECT_LT(fine, 0.003);
}

}  // namespace
}  // namespace typodont
