// Tests of laws of sweeps, with ticks of any length, random heads and random paths. A sweep is the motion of a head in
// one tick.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <new>
#include <random>
#include <span>

#include "engine/base/units.h"
#include "haptics/contact/tissue_patch.h"
#include "haptics/cutting/carve.h"
#include "haptics/cutting/cut_front.h"
#include "haptics/solid.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"
#include "tests/support/heads.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::CutFront;
using haptics::HeadShape;
using haptics::Sweep;
using haptics::TissuePatch;
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
    if (shape == HeadShape::kSphere) tool.length = tool.diameter;
    return tool;
  }
};

constexpr double kVoxel = 0.1_mm;
const VoxelFrame kFrame{{0, 0, 0}, kVoxel};

/// Returns dentin below z = `top` (voxels), large enough for a head at the origin.
TissuePatch block(const Tool& tool, double top) {
  TissuePatch patch;
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
  for (const HeadShape shape : test::shapes_but_the_ball()) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      Random random{std::mt19937_64(seed * 100 + static_cast<unsigned>(shape))};
      const Tool tool = random.head(shape);
      const bool slow = seed > 6;
      const double tick = slow ? random.scale(0.02, 0.05) : random.scale(0.055, 0.7),
                   reach = tool.reach() / kVoxel;  // voxels, distance of its farthest point
      const double turn = seed % 2 ? std::min(0.02, random.uniform(0.1, 0.9) * tick / reach) : 0;
      const dvec3 way = (tick - turn * reach) * kVoxel * random.direction(), axis = random.direction();
      const dquat R = rotation_between({0, 0, 1}, random.direction());
      const int ticks = static_cast<int>(std::ceil(3 / tick)), steps = 1000 / ticks;
      const auto at = [&](double i) {
        return Pose{(i - ticks / 2.0) * way, glm::normalize(glm::angleAxis(turn * i, axis) * R)};
      };

      TissuePatch by_ticks = block(tool, 100);
      carve(by_ticks, Sweep(tool, at(0), at(0), kFrame));
      TissuePatch by_steps = by_ticks;
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
  for (const HeadShape shape : test::head_shapes()) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      Random random{std::mt19937_64(seed * 100 + static_cast<unsigned>(shape))};
      const Tool tool = random.head(shape);
      TissuePatch plain = block(tool, -2), known = plain, eight = plain;
      CutFront front(std::span(&tool, 1), kVoxel), eight_front(std::span(&tool, 1), kVoxel, 8);
      Pose X{3 * kVoxel * random.direction(), rotation_between({0, 0, 1}, random.direction())};
      dvec3 v = random.direction();
      for (int i = 0; i < 60; ++i) {
        v = glm::normalize(v + 0.3 * random.direction() - X.p / (10 * kVoxel));
        const dquat turn = glm::angleAxis(i % 2 ? random.scale(1e-4, 0.02) : 0, random.direction());
        const Pose Y{X.p + random.scale(0.001, 1.2) * kVoxel * v, glm::normalize(turn * X.R)};
        const Sweep sweep(tool, X, Y, kFrame, i % 23 != 0);
        SCOPED_TRACE(testing::Message() << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i);
        bool changed, changed_known, changed_eight;
        const PerTissue taken = carve(plain, sweep, &changed);
        ASSERT_EQ(carve(known, sweep, &changed_known, &front), taken);
        ASSERT_EQ(carve(eight, sweep, &changed_eight, &eight_front), taken);
        ASSERT_TRUE(changed_known == changed && changed_eight == changed);
        ASSERT_TRUE(known.distance == plain.distance);
        ASSERT_TRUE(eight.distance == plain.distance);
        X = Y;
      }
    }
  }
}

/// Copies the samples of a patch that starts at voxel `lo` from a larger patch.
void copy_window(const TissuePatch& from, const glm::ivec3& lo, TissuePatch& to) {
  to.lo = lo;
  for (int x = 0; x < to.n; ++x) {
    for (int y = 0; y < to.n; ++y) {
      const glm::ivec3 at = lo - from.lo + glm::ivec3(x, y, 0);
      std::copy_n(from.distance.data() + from.at(at.x, at.y, at.z), to.n, to.distance.data() + to.at(x, y, 0));
      std::copy_n(from.tissue.data() + from.at(at.x, at.y, at.z), to.n, to.tissue.data() + to.at(x, y, 0));
    }
  }
}

TEST(Sweeps, AFrontThatPassesThroughManyPatchesChangesNoBitOfACutEvenIfAPatchEndsTwoVoxelsBesideTheSweep) {
  for (const HeadShape shape : test::head_shapes()) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      Random random{std::mt19937_64(seed * 100 + static_cast<unsigned>(shape))};
      const Tool tool = random.head(shape);
      const TissuePatch start = block(tool, -2);
      TissuePatch plain, window;
      // tissue everywhere, so that every sample of the window can change
      plain.resize(start.n + 40);
      plain.lo = start.lo - 20;
      std::fill(plain.distance.begin(), plain.distance.end(), -15.0f);
      std::fill(plain.tissue.begin(), plain.tissue.end(), Tissue::kDentin);
      window.resize(start.n - 6);
      CutFront front(std::span(&tool, 1), kVoxel);
      Pose X{2 * kVoxel * random.direction(), rotation_between({0, 0, 1}, random.direction())};
      dvec3 v = random.direction();
      for (int i = 0; i < 150; ++i) {
        v = glm::normalize(v + 0.3 * random.direction() - X.p / (8 * kVoxel));
        const dquat turn = glm::angleAxis(i % 3 ? 0 : random.scale(1e-4, 5e-3), random.direction());
        const Pose Y{X.p + random.scale(0.005, 0.15) * kVoxel * v, glm::normalize(turn * X.R)};
        const Sweep sweep(tool, X, Y, kFrame, i > 0);
        if (i % 5 == 0) {
          glm::ivec3 lo;
          for (int axis = 0; axis < 3; ++axis) {
            const int room = static_cast<int>(random.uniform(2, 9));
            lo[axis] = random.uniform(0, 1) < 0.5 ? sweep.lo()[axis] - room : sweep.hi()[axis] + room + 1 - window.n;
          }
          copy_window(plain, lo, window);
        }
        const PerTissue taken = carve(plain, sweep);
        ASSERT_EQ(carve(window, sweep, nullptr, &front), taken)
            << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i;
        X = Y;
        if (i % 5 != 4) continue;
        TissuePatch expected = window;
        copy_window(plain, window.lo, expected);
        ASSERT_TRUE(window.distance == expected.distance)
            << static_cast<int>(shape) << ", seed " << seed << ", sweep " << i;
      }
    }
  }
}

/// A drill that moves in and out of a block of bone, mostly along its axis; sometimes it is moved aside, turned about
/// its axis, or withdrawn, or a sweep does not continue the one before.
struct DrillInBone {
  Random random;
  Tool tool;
  Pose X;
  int i = 0;

  explicit DrillInBone(unsigned seed) : random{std::mt19937_64(seed)} {
    tool.shape = HeadShape::kCylinder;
    tool.diameter = random.uniform(0.9_mm, 1.3_mm);
    tool.length = tool.diameter * random.uniform(1.5, 2.2);
    auto drill = std::make_shared<haptics::ImplantTool>();
    drill->kind = haptics::ImplantToolKind::kDrill;
    tool.implant = drill;
    const dquat R = seed % 3 == 0 ? dquat(1, 0, 0, 0) : rotation_between({0, 0, 1}, random.direction());
    X = {R * dvec3(0, 0, tool.half() + 4 * kVoxel), R};
  }
  Sweep next(const VoxelFrame& frame = kFrame) {
    const bool turns = i / 20 % 2 == 1, aside = i % 29 == 28, back = i % 31 >= 28;
    const dquat about_axis = glm::angleAxis(turns ? random.uniform(-0.02, 0.02) : 0, dvec3(0, 0, 1));
    const double step = random.scale(0.002, i / 40 % 2 ? 0.4 : 0.02) * kVoxel;
    dvec3 way = X.R * dvec3(0, 0, back ? step : -step);
    if (aside) way += 0.05 * kVoxel * random.direction();
    const Pose Y{X.p + way, glm::normalize(X.R * about_axis)};
    const Sweep sweep(tool, X, Y, frame, i % 37 != 0);
    X = Y;
    ++i;
    return sweep;
  }
};

TEST(Sweeps, ADrillThatMovesAlongItsAxisCutsTheSameBitsWithTheFrontAndInTheTissue) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    DrillInBone drill(seed);
    haptics::TissueVolume volume(haptics::read_solids(Json::parse(
        R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [4, 4, 4]}}}]})", "tissue")));
    const VoxelFrame frame = volume.frame();
    ASSERT_EQ(frame.voxel, kVoxel);
    TissuePatch plain = block(drill.tool, 1000);
    plain.lo += glm::ivec3(glm::round(frame.to_voxels(dvec3(0))));
    volume.copy(plain.lo, glm::ivec3(plain.n), plain.distance.data(), plain.tissue.data());
    TissuePatch known = plain, eight = plain;
    CutFront front(std::span(&drill.tool, 1), kVoxel), eight_front(std::span(&drill.tool, 1), kVoxel, 8);
    double removed = 0;
    for (int i = 0; i < 240; ++i) {
      const Sweep sweep = drill.next(frame);
      const PerTissue taken = carve(plain, sweep);
      volume.carve(sweep);
      ASSERT_EQ(carve(known, sweep, nullptr, &front), taken) << "seed " << seed << ", sweep " << i;
      ASSERT_EQ(carve(eight, sweep, nullptr, &eight_front), taken) << "seed " << seed << ", sweep " << i;
      ASSERT_TRUE(known.distance == plain.distance) << "seed " << seed << ", sweep " << i;
      ASSERT_TRUE(eight.distance == plain.distance) << "seed " << seed << ", sweep " << i;
      if (i % 20 == 19) {
        TissuePatch carved = plain;
        volume.copy(carved.lo, glm::ivec3(carved.n), carved.distance.data(), carved.tissue.data());
        ASSERT_TRUE(carved.distance == plain.distance) << "seed " << seed << ", sweep " << i;
      }
      removed += total(taken);
    }
    EXPECT_GT(removed, 100) << "seed " << seed;
  }
}

TEST(Sweeps, ADrillThatMovesAlongItsAxisLeavesTheTissueOfTheWholeHeadsSweep) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    DrillInBone end(seed), whole(seed);
    whole.tool.implant = nullptr;  // cuts with its whole head
    TissuePatch by_end = block(end.tool, 1000), by_whole = by_end;
    double end_removed = 0, whole_removed = 0;
    for (int i = 0; i < 240; ++i) {
      end_removed += total(carve(by_end, end.next()));
      whole_removed += total(carve(by_whole, whole.next()));
    }
    float apart = 0;
    for (std::size_t i = 0; i < by_end.distance.size(); ++i)
      apart = std::max(apart, std::abs(by_end.distance[i] - by_whole.distance[i]));
    EXPECT_LT(apart, 1e-4f) << "voxels, seed " << seed;
    EXPECT_NEAR(end_removed / whole_removed, 1, 1e-6) << "seed " << seed;
  }
}

TEST(Sweeps, TheSameHeadIsRecognisedWhateverTheMemoryOfASweepHeldBefore) {
  Tool tool;
  tool.shape = HeadShape::kCylinder;
  tool.diameter = 1.0_mm, tool.length = 3.0_mm;
  alignas(Sweep) unsigned char memory[2][sizeof(Sweep)];
  std::fill_n(memory[0], sizeof(Sweep), static_cast<unsigned char>(0));
  std::fill_n(memory[1], sizeof(Sweep), static_cast<unsigned char>(0x5a));
  asm volatile("" ::: "memory");  // keeps the compiler from leaving out what a constructor seems to overwrite
  const auto* const a = new (memory[0]) Sweep(tool, {}, {}, {{}, 0.1_mm});
  const auto* const b = new (memory[1]) Sweep(tool, {}, {}, {{}, 0.1_mm});
  EXPECT_TRUE(a->same_head(*b));
  tool.length = 2.0_mm;
  EXPECT_FALSE(a->same_head(Sweep(tool, {}, {}, {{}, 0.1_mm})));
}

}  // namespace
}  // namespace typodont
