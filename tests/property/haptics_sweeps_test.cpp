// Laws of sweeps: ticks of any length, random heads and ways.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <span>
#include <vector>

#include "engine/base/units.h"
#include "haptics/cut_front.h"
#include "haptics/cutting/carve.h"
#include "haptics/surface_patch.h"
#include "tests/support/heads.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::CutFront;
using haptics::HeadShape;
using haptics::SurfacePatch;
using haptics::Sweep;
using haptics::Tool;

struct Random {
  std::mt19937_64 engine;
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  double scale(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  dvec3 direction() {
    std::normal_distribution<double> normal;
    return glm::normalize(dvec3(normal(engine), normal(engine), normal(engine)));
  }
  Tool head(HeadShape shape) {
    Tool tool;
    tool.shape = shape;
    tool.diameter = uniform(0.6_mm, 1.4_mm);
    tool.length = tool.diameter * (shape == HeadShape::kInvertedCone ? uniform(0.8, 1.2) : uniform(1.5, 2.5));
    return tool;
  }
};

const std::vector<HeadShape> kNoBalls = test::shapes_but_the_ball();
constexpr double kVoxel = 0.1_mm;
const VoxelFrame kFrame{{0, 0, 0}, kVoxel};

/// Dentin below z = `top`, with room around a head at the origin, voxels.
SurfacePatch block(const Tool& tool, double top) {
  SurfacePatch patch;
  patch.resize(2 * static_cast<int>(std::ceil(tool.reach() / kVoxel) + 15));
  patch.lo = glm::ivec3(-patch.n / 2);
  for (std::size_t i = 0; i < patch.distance.size(); ++i) {
    const double z = static_cast<double>(i % static_cast<std::size_t>(patch.n)) + patch.lo.z;
    patch.distance[i] = static_cast<float>(std::clamp(z - top, -15.0, 15.0));
    patch.tissue[i] = Tissue::kDentin;
  }
  return patch;
}

TEST(Sweeps, SlowAndFastTicksRemoveTheVolumeOfAThousandSmallSteps) {
  double worst = 0, worst_slow = 0;
  for (const HeadShape shape : kNoBalls) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      Random random{std::mt19937_64(seed * 100 + static_cast<unsigned>(shape))};
      const Tool tool = random.head(shape);
      const bool slow = seed > 6;
      const double tick = slow ? random.scale(0.02, 0.05) : random.scale(0.055, 0.7),
                   reach = tool.reach() / kVoxel;  // voxels, of its farthest point
      const double turn = seed % 2 ? std::min(0.02, random.uniform(0.1, 0.9) * tick / reach) : 0;
      const dvec3 way = (tick - turn * reach) * kVoxel * random.direction(), axis = random.direction();
      const dquat R = rotation_between({0, 0, 1}, random.direction());
      const int ticks = static_cast<int>(std::ceil(3 / tick)), steps = 1000 / ticks;
      const auto at = [&](double i) {
        return Pose{(i - ticks / 2.0) * way, glm::normalize(glm::angleAxis(turn * i, axis) * R)};
      };

      SurfacePatch by_ticks = block(tool, 100);
      carve(by_ticks, Sweep(tool, at(0), at(0), kFrame));
      SurfacePatch by_steps = by_ticks;
      CutFront front(std::span(&tool, 1), kVoxel), fine_front(std::span(&tool, 1), kVoxel);
      double ticked = 0, stepped = 0;
      Pose last = at(0);
      for (int i = 0; i < ticks; ++i) {
        ticked += total(carve(by_ticks, Sweep(tool, at(i), at(i + 1), kFrame, true), nullptr, &front));
        for (int k = 1; k <= steps; ++k) {
          const Pose next = k == steps ? at(i + 1) : interpolate(at(i), at(i + 1), static_cast<double>(k) / steps);
          stepped += total(carve(by_steps, Sweep(tool, last, next, kFrame, true), nullptr, &fine_front));
          last = next;
        }
      }
      EXPECT_NEAR(ticked / stepped, 1, slow ? 3e-3 : 2e-4)
          << static_cast<int>(shape) << ", seed " << seed << ", ticks of " << tick << " voxels, turned by " << turn;
      double& most = slow ? worst_slow : worst;
      most = std::max(most, std::abs(ticked / stepped - 1));
    }
  }
  std::printf("ticks: %.1e, slow ones %.1e\n", worst, worst_slow);
}

TEST(Sweeps, TheActiveFrontListsChangeNoBitOfACut) {
  for (const HeadShape shape : kNoBalls) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      Random random{std::mt19937_64(seed * 100 + static_cast<unsigned>(shape))};
      const Tool tool = random.head(shape);
      SurfacePatch plain = block(tool, -2), known = plain, eight = plain;
      CutFront front(std::span(&tool, 1), kVoxel), eight_front(std::span(&tool, 1), kVoxel, 8);
      Pose X{3 * kVoxel * random.direction(), rotation_between({0, 0, 1}, random.direction())};
      dvec3 v = random.direction();
      for (int i = 0; i < 60; ++i) {
        v = glm::normalize(v + 0.3 * random.direction() - X.p / (10 * kVoxel));
        const dquat turn = glm::angleAxis(i % 2 ? random.scale(1e-4, 0.02) : 0, random.direction());
        const Pose Y{X.p + random.scale(0.001, 1.2) * kVoxel * v, glm::normalize(turn * X.R)};
        const Sweep sweep(tool, X, Y, kFrame, i % 23 != 0);
        const PerTissue taken = carve(plain, sweep);
        ASSERT_EQ(carve(known, sweep, nullptr, &front), taken)
            << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i;
        ASSERT_EQ(carve(eight, sweep, nullptr, &eight_front), taken)
            << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i;
        ASSERT_TRUE(known.distance == plain.distance)
            << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i;
        ASSERT_TRUE(eight.distance == plain.distance)
            << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i;
        X = Y;
      }
    }
  }
}

TEST(Sweeps, AHeadThatSwingsInItsHoleCutsTheSameBitsWithTheFrontAndVersionsOfTheLawsDifferByAHundredthOfAVoxel) {
  constexpr std::uint32_t kLaws[] = {4, 5};
  for (const HeadShape shape : kNoBalls) {
    for (unsigned seed = 1; seed <= 2; ++seed) {
      Random random{std::mt19937_64(seed * 100 + static_cast<unsigned>(shape))};
      Tool tool = random.head(shape);
      if (shape != HeadShape::kInvertedCone) tool.length *= 2;
      const dquat R = rotation_between({0, 0, 1}, random.direction());
      const dvec3 axis = random.direction(), way = random.scale(0.2, 4) * kVoxel * random.direction();
      const double rate = random.uniform(0.1, 0.4);  // rad of the swing's phase in a tick
      SurfacePatch plain[] = {block(tool, 1000), block(tool, 1000)}, known[] = {plain[0], plain[1]};
      double taken[2] = {};
      for (std::size_t k = 0; k < 2; ++k) {
        CutFront front(std::span(&tool, 1), kVoxel);
        const auto at = [&](int i) {
          const double swing = std::sin(rate * i) * (i / 40 % 2 ? 0.1 : 1);  // by turns fast and slow
          return Pose{swing * way, glm::normalize(glm::angleAxis(0.02 / rate * swing, axis) * R)};
        };
        carve(plain[k], Sweep(tool, at(0), at(0), kFrame, false, kLaws[k]));
        carve(known[k], Sweep(tool, at(0), at(0), kFrame, false, kLaws[k]), nullptr, &front);
        for (int i = 0; i < 120; ++i) {
          const Sweep sweep(tool, at(i), at(i + 1), kFrame, i % 41 != 0, kLaws[k]);
          const PerTissue removed = carve(plain[k], sweep);
          taken[k] += total(removed);
          ASSERT_EQ(carve(known[k], sweep, nullptr, &front), removed)
              << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i << ", laws " << kLaws[k];
          ASSERT_TRUE(known[k].distance == plain[k].distance)
              << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i << ", laws " << kLaws[k];
        }
      }
      // Beyond kMargin a sample keeps its value.
      const auto kept = [](float distance) { return std::max(distance, -Sweep::kMargin); };
      float apart = 0;
      for (std::size_t i = 0; i < plain[0].distance.size(); ++i)
        apart = std::max(apart, std::abs(kept(plain[0].distance[i]) - kept(plain[1].distance[i])));
      EXPECT_LT(apart, 0.0125f) << static_cast<int>(shape) << ", seed " << seed;
      EXPECT_NEAR(taken[1] / taken[0], 1, 1e-3) << static_cast<int>(shape) << ", seed " << seed;
    }
  }
}

TEST(Sweeps, TicksTakeTheSameInAnyOrderAndNothingTwice) {
  for (const HeadShape shape : kNoBalls) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      Random random{std::mt19937_64(seed * 100 + static_cast<unsigned>(shape))};
      const Tool tool = random.head(shape);
      std::vector<Sweep> sweeps;
      for (int i = 0; i < 8; ++i) {
        const Pose X{3 * kVoxel * random.direction(), rotation_between({0, 0, 1}, random.direction())};
        const dvec3 way = random.scale(0.02, 1) * kVoxel * random.direction();
        const dquat turn = glm::angleAxis(i % 2 * 0.01, random.direction());
        sweeps.emplace_back(tool, X, Pose{X.p + way, glm::normalize(turn * X.R)}, kFrame);
      }
      SurfacePatch patch = block(tool, -2), backwards = patch;
      double taken = 0, taken_backwards = 0;
      for (const Sweep& sweep : sweeps) taken += total(carve(patch, sweep));
      for (auto sweep = sweeps.rbegin(); sweep != sweeps.rend(); ++sweep)
        taken_backwards += total(carve(backwards, *sweep));
      EXPECT_GT(taken, 10);
      EXPECT_EQ(taken, taken_backwards) << static_cast<int>(shape) << ", seed " << seed;
      EXPECT_TRUE(patch.distance == backwards.distance) << static_cast<int>(shape) << ", seed " << seed;
      for (const Sweep& sweep : sweeps) {
        bool changed;
        EXPECT_EQ(total(carve(patch, sweep, &changed)), 0) << static_cast<int>(shape) << ", seed " << seed;
        EXPECT_FALSE(changed) << static_cast<int>(shape) << ", seed " << seed;
      }
    }
  }
}

}  // namespace
}  // namespace typodont
