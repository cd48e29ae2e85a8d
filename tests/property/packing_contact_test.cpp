// Tests of the proxy in contact with spheres: it follows the hand, stops, slides, sticks, and never passes through the
// tissue.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "engine/base/units.h"
#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/packing.h"
#include "haptics/solid.h"
#include "tests/support/sphere_cut.h"

namespace typodont::haptics::packing {
namespace {

using namespace literals;

constexpr double kPlaneRadius = 100;  // m

/// Returns a sphere that is so large that its surface is nearly the plane z = 0.
SphereTree plane() {
  const std::vector<dvec3> center = {dvec3(0, 0, -kPlaneRadius)};
  const std::vector<double> radius = {kPlaneRadius};
  return SphereTree(center, radius);
}

ToolSpheres ball_tool(double r = 0.5_mm) {
  return ToolSpheres({dvec3(0)}, {r});
}
Pose at(double x, double y, double z) {
  return {dvec3(x, y, z), {1, 0, 0, 0}};
}
dvec3 random_in(std::mt19937_64& random, double half) {
  std::uniform_real_distribution<double> u(-half, half);
  const double x = u(random), y = u(random), z = u(random);
  return {x, y, z};
}

TEST(SphereProxy, InACornerItRestsOnThreeSpheresAndTheNormalPointsOut) {
  std::vector<dvec3> center;
  std::vector<double> radius;
  for (int k = 0; k < 6; ++k) {
    center.push_back(1.0_mm * dvec3(std::cos(k * kPi / 3), std::sin(k * kPi / 3), 0));
    radius.push_back(0.49_mm);
  }
  const SphereTree tree(center, radius);
  SphereProxy proxy(ball_tool(0.8_mm), {.static_friction = 0, .dynamic_friction = 0});
  proxy.place(at(0, 0, 3.0_mm));
  for (int i = 0; i < 50; ++i) proxy.follow(tree, at(0.01_mm, 0.005_mm, 0));
  const double rest = std::sqrt(1.29 * 1.29 - 1.0);  // on the axis the tool would touch all six at once
  EXPECT_NEAR(proxy.pose().p.z, rest * 1.0_mm, 1.0e-6);
  EXPECT_GE(proxy.contacts().size(), 2u);
  dvec3 normal(0);
  for (const ProxyContact& contact : proxy.contacts()) normal += contact.push * contact.n_W;
  EXPECT_GT(glm::normalize(normal).z, 0.99);
}

TEST(SphereProxy, ItNeverOverlapsASphereHoweverTheHandMoves) {
  std::mt19937_64 random(1);
  const DenseTissue tissue = read_solids(Json::parse(
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"sphere": {"radius_mm": 2}}}]})", "t"));
  PackOptions options;
  options.spheres = 1500;
  const SpherePacking p = pack_spheres(tissue, options);
  const SphereTree tree(p.center, p.radius);
  Tool cylinder;
  cylinder.shape = HeadShape::kCylinder, cylinder.diameter = 1.0_mm, cylinder.length = 3.0_mm;
  for (const ToolSpheres& tool : {ball_tool(), tool_spheres(cylinder, 30)}) {
    SphereProxy proxy(tool, {});
    proxy.place(at(0, 0, 6.0_mm));
    double deepest = 0;
    int touched = 0;
    for (int i = 0; i < 3000; ++i) {
      const dquat R = glm::normalize(dquat(1, 0.3 * std::sin(0.01 * i), 0.4 * std::cos(0.013 * i), 0.2));
      const dvec3 leap = i % 100 == 0 ? random_in(random, 5.0_mm) : dvec3(0);
      const dvec3 p_WH = 2.2_mm * dvec3(std::sin(0.011 * i), std::cos(0.017 * i), std::sin(0.007 * i)) + leap;
      proxy.follow(tree, {p_WH, R});
      touched += proxy.touches();
      for (std::size_t k = 0; k < tool.radius.size(); ++k) {
        const dvec3 c = proxy.pose() * tool.center_T[k];
        for (std::size_t j = 0; j < p.size(); ++j) {
          deepest = std::max(deepest, p.radius[j] + tool.radius[k] - glm::distance(c, p.center[j]));
        }
      }
    }
    EXPECT_GT(touched, 500);
    // The sweep of a rotation follows chords. Their distance from the arcs is below this limit.
    EXPECT_LT(deepest, tool.radius.size() == 1 ? 1e-12 : 1.0e-6);
  }
}

TEST(SphereProxy, NearListsThatAreMadeInPartsContainEveryNearSphereWhileALargeHeadMovesAndCuts) {
  const DenseTissue bone = read_solids(Json::parse(
      R"({"voxel_mm": 0.8, "band_mm": 4, "solids": [{"tissue": "cancellous_bone", "solid": {"difference": [
      {"box": {"size_mm": [40, 40, 16]}}, {"sphere": {"center_mm": [0, 0, 21], "radius_mm": 22.3}}]}}]})",
      "t"));
  PackOptions options;
  options.spheres = 30000;
  const SpherePacking p = pack_spheres(bone, options);
  SphereTissue tissue(p, Removal::kMended);
  const SphereTree& tree = tissue.tree();
  const double r = 22.0_mm, epsilon = 0.05_mm;
  SphereProxy proxy(ball_tool(r), {});
  proxy.place(at(0, 0, 24.0_mm));
  std::vector<Place> listed(p.size()), near(p.size()), changed(p.size());
  std::vector<CutSphere> before(p.size());
  double deepest = -1;
  std::size_t most = 0, cut = 0;
  for (int i = 0; i < 600; ++i) {
    const double down = i < 60 ? 24.0_mm - 0.06_mm * i : 20.0_mm;
    proxy.follow(tree, at(0.5_mm * std::sin(0.02 * i), 0.5_mm * std::cos(0.03 * i), i % 200 > 190 ? 21.8_mm : down));
    const dvec3 c = proxy.pose().p;
    for (int j = 0; j < static_cast<int>(p.size()); ++j) {
      if (tree.radius(j) > 0) deepest = std::max(deepest, tree.radius(j) + r - glm::distance(c, tree.center(j)));
    }
    if (!proxy.touches()) continue;
    const std::size_t wanted = tree.near_segment(c, c, r + epsilon, near);
    listed.resize(std::min(proxy.near_here(tree, 0, epsilon, listed), listed.size()));
    std::erase_if(
        listed, [&](Place place) { return glm::distance(c, tree.center(place)) >= tree.radius(place) + r + epsilon; });
    ASSERT_TRUE(std::ranges::equal(listed, std::span(near).first(wanted))) << i;
    listed.resize(p.size());
    most = std::max(most, wanted);
    if (i % 3 != 0) continue;
    const dvec3 to = c - dvec3(0, 0, i % 30 == 0 ? 20e-6 : 1e-6);
    Removed removed;
    const std::size_t count = cut_with_ball(tissue, c, to, r, changed, before, removed);
    for (std::size_t k = 0; k < count; ++k) {
      const double shift = glm::distance(tree.center(changed[k]), before[k].center());
      proxy.note_cut(tree, changed[k], shift + tree.radius(changed[k]) - before[k].radius());
    }
    proxy.end_notes();
    proxy.move_to({to, {1, 0, 0, 0}});
    cut += count;
  }
  EXPECT_LT(deepest, 1e-11);
  EXPECT_GT(most, 1200u);
  EXPECT_GT(cut, 10000u);
}

TEST(SphereProxy, NoneOfTenThousandHandsPassesAThinSheetAtUpTo20MillimetresATick) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> u(0, 1);
  int through = 0, met = 0;
  for (const double thick : {0.2, 0.4, 0.7, 1.0}) {
    const DenseTissue sheet = read_solids(Json::parse(fmt::format(R"({{"voxel_mm": 0.05, "band_mm": 0.4, "solids": [
          {{"tissue": "enamel", "solid": {{"box": {{"size_mm": [6, 6, {}]}}}}}}]}})",
                                                                  thick),
                                                      "t"));
    PackOptions options;
    options.spheres = 6000;
    const SpherePacking p = pack_spheres(sheet, options);
    const SphereTree tree(p.center, p.radius);
    for (int i = 0; i < 2500; ++i) {
      const double r = 0.25_mm + 0.75_mm * u(random), speed = 20.0_mm * u(random);
      SphereProxy proxy(ball_tool(r), {});
      const dvec3 from(3.0_mm * (u(random) - 0.5), 3.0_mm * (u(random) - 0.5), r + 0.6_mm + 2.0_mm * u(random));
      const dvec3 to(3.0_mm * (u(random) - 0.5), 3.0_mm * (u(random) - 0.5), -r - 0.6_mm - 10.0_mm * u(random));
      proxy.place({from, {1, 0, 0, 0}});
      const int ticks = std::max(1, static_cast<int>(glm::distance(from, to) / std::max(speed, 0.1_mm)));
      for (int k = 1; k <= ticks + 20; ++k) {
        proxy.follow(tree, {glm::mix(from, to, std::min(1.0, static_cast<double>(k) / ticks)), {1, 0, 0, 0}});
      }
      met += proxy.touches();
      through += proxy.pose().p.z < 0;
    }
  }
  EXPECT_EQ(met, 10'000);
  EXPECT_EQ(through, 0);
}

TEST(SphereProxy, AHandThatJumps100MillimetresIsFollowedWithinTheLimitAndNotThroughTheTissue) {
  constexpr double kLimit = 5.0_mm;
  const SphereTree tree = plane();
  ToolSpheres tool = ball_tool();
  tool.add_non_cutting(dvec3(0, 0, 20.0_mm), 1.0_mm);
  SphereProxy proxy(tool, {.static_friction = 0, .dynamic_friction = 0, .longest_path = kLimit});
  proxy.place(at(0, 0, 30.0_mm));
  const Pose hand{dvec3(80.0_mm, 0, -30.0_mm), glm::angleAxis(0.5, dvec3(0, 1, 0))};
  for (int i = 0; i < 60; ++i) {
    const Pose before = proxy.pose();
    proxy.follow(tree, hand);
    for (std::size_t t = 0; t < tool.size(); ++t) {
      const dvec3 p = proxy.pose() * tool.center_T[t];
      ASSERT_LE(glm::distance(before * tool.center_T[t], p), kLimit * (1 + 1e-9)) << i;
      // The surface of plane() is curved. A rotation may deviate from its chord by 5e-5 of the tool's length.
      ASSERT_GE(glm::distance(p, dvec3(0, 0, -kPlaneRadius)), kPlaneRadius + tool.radius[t] - 5e-5 * tool.reach) << i;
    }
  }
  EXPECT_NEAR(proxy.pose().p.x, 80.0_mm, 0.1_mm);
}

/// The tissue that the head cuts stops the head. At the same time the shank touches tissue that is oblique to the
/// motion.
TEST(SphereProxy, TheHeadSlidesAlongTheShanksContactAndContinuesToCut) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> fraction(0, 1);
  for (int i = 0; i < 200; ++i) {
    const double head = 0.5_mm, shank = 0.3_mm, bone = 0.1_mm + 0.4_mm * fraction(random), height = 2.0_mm;
    const double across = 0.2 + 0.7 * fraction(random), around = 2 * kPi * fraction(random);
    const dvec3 toward(across, std::sqrt(1 - across * across) * std::cos(around),
                       // direction from the shank's sphere to the tissue
                       std::sqrt(1 - across * across) * std::sin(around));
    const double gap = SphereProxy::kGap;  // gap that a cut leaves
    const std::vector<dvec3> center = {dvec3(head + 0.5_mm + gap, 0, 0),
                                       dvec3(0, 0, height) + (shank + bone + gap) * toward};
    const std::vector<double> radius = {0.5_mm, bone};
    const SphereTree tree(center, radius);
    ToolSpheres tool = ball_tool(head);
    tool.add_non_cutting(dvec3(0, 0, height), shank);
    SphereProxy proxy(tool, {.static_friction = 0, .dynamic_friction = 0});
    proxy.place(at(0, 0, 0));
    proxy.follow(tree, at(1.0_mm, 0, 0));
    ASSERT_TRUE(proxy.touches());

    dvec3 move(1.0_mm, 0, 0), turn(0);
    const double part = proxy.non_cutting_parts_allow(tree, 0.05_mm, move, turn);
    ASSERT_GT(part * move.x, 0.01_mm) << i;
    // The largest allowed step of the cut.
    const double step = std::min(part, 0.05_mm / glm::length(move));
    const Pose to{proxy.pose().p + step * move, SphereProxy::turned_by(step * turn) * proxy.pose().R};
    ASSERT_GT(glm::distance(to * dvec3(0, 0, height), center[1]), shank + bone - 1e-9) << i;
  }
}

}  // namespace
}  // namespace typodont::haptics::packing
