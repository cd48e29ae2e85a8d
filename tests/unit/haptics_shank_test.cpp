// Tests the parts of a tool that never cut: shank and safe end push back, rotate the tool, and remove nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/proxy/non_cutting_contacts.h"
#include "haptics/cutting/carve.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using haptics::ServoSettings;
using haptics::Tool;
using test::HapticBench;

Tool bur_with_shank() {
  Tool tool;
  tool.diameter = tool.length = 1.0_mm;
  tool.shank_length = 8.0_mm;
  tool.shank_diameter = 1.6_mm;
  tool.neck_diameter = 0.6_mm;
  tool.neck_length = 2.0_mm;
  return tool;
}

ServoSettings settings(const Tool& tool, double damping = 0) {
  ServoSettings s;
  s.tool = tool;
  s.friction = false;
  s.damping = damping;
  s.spindle.free_speed = 300.0_krpm;
  return s;
}

/// A wall with its face at x = 0, above z = 3 mm. It is beside the shank, and the head below cannot reach it.
constexpr const char* kWall = R"({"voxel_mm": 0.1, "solids": [
  {"tissue": "enamel", "solid": {"box": {"center_mm": [2.5, 0, 6], "size_mm": [5, 8, 6]}}}]})";

/// Moves an upright tool in x to `x` at 20 mm/s. The tool's head is at the height of the origin.
void lean(HapticBench& bench, double x, double pedal = 0, int hold = 200) {
  const double from = -1.2_mm;
  for (double at = from; at < x; at += 20e-6) bench.tick({{at, 0, 0}}, pedal);
  for (int i = 0; i < hold; ++i) bench.tick({{x, 0, 0}}, pedal);
}

TEST(Shank, PushesBackWithStiffnessTimesDepthAndTurnsTheToolAboutItsHead) {
  HapticBench bench(kWall, settings(bur_with_shank()));
  lean(bench, -0.6_mm);  // the shank of 0.8 mm in radius, 0.2 mm too far
  EXPECT_NEAR(bench.last.f_T_W.x, -0.2, 5e-3);
  EXPECT_NEAR(glm::length(bench.last.f_T_W), 0.2, 5e-3);
  EXPECT_EQ(bench.last.tissue, Tissue::kEnamel);
  EXPECT_NEAR(bench.last.X_WG.p.x, -0.8_mm, 5e-6);
  // The wall touches the shank above z = 3 mm. So the torque about the head is at least the force times this height.
  EXPECT_NEAR(bench.last.tau_T_W.x, 0, 1e-5);
  EXPECT_LT(bench.last.tau_T_W.y, -0.2 * 2.9e-3);
  EXPECT_GT(bench.last.tau_T_W.y, -0.2 * 8.6e-3);
  EXPECT_EQ(bench.last.faults, 0u);
}

TEST(Shank, RemovesNothingHoweverHardItIsPressedWithTheDrillRunning) {
  HapticBench bench(kWall, settings(bur_with_shank()));
  const std::uint64_t before = bench.carver.volume().hash();
  lean(bench, 1.0_mm, 1, 500);
  EXPECT_GT(-bench.last.f_T_W.x, 1.5);
  EXPECT_EQ(total(bench.last.removed), 0);
  EXPECT_EQ(bench.carver.volume().hash(), before);
}

TEST(Shank, AToolWithoutAShankPassesFreely) {
  Tool tool = bur_with_shank();
  tool.shank_length = 0;
  HapticBench bench(kWall, settings(tool));
  lean(bench, 1.0_mm);
  EXPECT_EQ(glm::length(bench.last.f_T_W), 0);
}

TEST(Shank, StopsABurThatWouldCutDeeper) {
  // A groove that is wide enough for the head, but not for the shank, which becomes wider above the head.
  Tool tool = bur_with_shank();
  tool.neck_length = 1.0_mm;
  constexpr const char* kGroove = R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
    {"box": {"size_mm": [6, 6, 8]}}, {"box": {"center_mm": [0, 0, 3], "size_mm": [1.2, 8, 4]}}]}}]})";
  HapticBench bench(kGroove, settings(tool, 2));
  double z = 5.0_mm;
  for (int i = 0; i < 4000; ++i) {
    z = std::max(z - 5e-6, 2.0_mm);
    bench.tick({{0, 0, z}}, 1);
  }
  // The shank is 1.2 mm wide at 1.0 mm above the head. There the rim of the groove, at z = 4 mm, holds the shank. The
  // position of a rim has an error of a tenth of a millimetre; along such a slim cone, this is more than 0.2 mm.
  EXPECT_NEAR(bench.last.X_WG.p.z, 3.0_mm, 0.3_mm);
  EXPECT_GT(bench.last.f_T_W.z, 0.3);
  EXPECT_EQ(total(bench.last.removed), 0);
}

TEST(Shank, FollowsTheHeadIntoTheHoleItDrills) {
  Tool tool = bur_with_shank();
  tool.neck_length = 8.0_mm;  // 1 mm wide only 3.2 mm above the head
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 8]}}}]})";
  Tool plain = tool;
  plain.shank_length = 0;
  double removed[2];
  int which = 0;
  for (const Tool& t : {tool, plain}) {
    HapticBench bench(kBlock, settings(t, 2));
    double z = 4.6_mm;
    for (int i = 0; i < 3500; ++i) {
      z -= 0.8e-6;
      bench.tick({{0, 0, z}}, 1);
    }
    removed[which++] = total(bench.last.removed);
  }
  EXPECT_GT(removed[1], 0.7e-9);
  EXPECT_NEAR(removed[0], removed[1], 1e-3 * removed[1]) << "the neck is narrower than the hole";
}

TEST(Shank, WithoutANewSnapshotTheCoarsePatchFollowsAFastDrillWithinFiveTicks) {
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [18, 18, 8]}}}]})";
  constexpr std::size_t kLater = 5;  // ticks
  Tool drill = bur_with_shank();
  drill.shape = HeadShape::kRoundEndCylinder;
  drill.diameter = 3.0_mm, drill.length = 8.0_mm;
  MaterialTable soft = test::plain_materials();
  for (auto& material : soft) material.specific_energy /= 1000;
  HapticBench bench(haptics::TissueVolume(haptics::read_solids(Json::parse(kBlock, "tissue"))), settings(drill), soft);
  const double top = 4.0_mm + drill.length / 2;
  for (int i = 0; i < 600; ++i) bench.tick({{0, 0, top - 6e-3 * i / 600}}, 1);
  bench.steps.take_snapshot(bench.last.X_WG.p);
  bench.steps.adopt_snapshot();
  std::vector<dvec3> empty;  // places near the head's flank; the fine patch shows no tissue there
  std::size_t fast = 0;
  for (int i = 0; i < 400; ++i) {  // up to 0.5 m/s and 20 rad/s to and fro
    const dvec3 before = bench.last.X_WG.p;
    const double aside = 2.6_mm * std::sin(2 * kPi * 0.030 * i), turn = 0.26 * std::sin(2 * kPi * 0.012 * i);
    const Pose X_WT{{aside, 0.3 * aside, top - 6e-3}, glm::angleAxis(turn, glm::normalize(dvec3(0.8, 0.6, 0)))};
    const bool did_cut = bench.steps.tick_servo({bench.t, X_WT, 1, 0, 0}, bench.last, bench.cut);
    bench.t += from_seconds(bench.settings.tick);
    const Pose& X = bench.last.X_WG;
    const dvec3 side = X.p + X.R * dvec3(X.p.x > before.x ? 1.0_mm : -1.0_mm, 0, -1.0_mm);
    const VoxelFrame& fine = bench.settings.frame;
    empty.push_back(haptics::sample_linear(bench.patch(), fine.to_voxels(side)) > 2 ? side : dvec3(0, 0, 1));
    fast += did_cut && glm::length(X.p - before) > 0.3_mm;
    if (empty.size() <= kLater || empty[empty.size() - 1 - kLater].z == 1) continue;
    const auto& wide = bench.patch().coarse_levels.front();
    const VoxelFrame frame{fine.origin, fine.voxel * wide.every};
    ASSERT_GT(haptics::sample_linear(wide, frame.to_voxels(empty[empty.size() - 1 - kLater])), 0) << i;
  }
  EXPECT_GT(fast, 10u);
}

TEST(Shank, IsFeltWhereverTheToolIsTilted) {
  // The tool lies on the edge of a block: the head is in the air beyond the edge, and the shank lies across it.
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"box": {"center_mm": [4, 0, -2], "size_mm": [6, 8, 4]}}}]})";
  for (const double tilt : {60.0, 75.0, 90.0}) {
    HapticBench bench(kBlock, settings(bur_with_shank()));
    const double a = tilt * kPi / 180;
    const dquat R = glm::angleAxis(a, dvec3(0, 1, 0));  // +z towards +x
    // The pose is chosen so that the shank sinks 0.2 mm into the edge at (1, ·, 0). It touches the edge 4 mm above its
    // lower end, where its radius is 0.8 mm.
    const dvec3 axis(std::sin(a), 0, std::cos(a)), out(-std::cos(a), 0, std::sin(a));
    const dvec3 end = dvec3(1.0_mm, 0, 0) + (0.8_mm - 0.2_mm) * out - 4.4_mm * axis;
    for (int i = 0; i <= 400; ++i) bench.tick({end + (1.0_mm - 5e-6 * std::min(i, 200)) * out, R}, 0);
    for (int i = 0; i < 100; ++i) bench.tick({end, R}, 0);
    const double along = glm::dot(bench.last.f_T_W, out);
    EXPECT_NEAR(along, 0.2, 0.03) << tilt;
    EXPECT_NEAR(std::abs(bench.last.tau_T_W.y), along * 4.4e-3, 0.1 * along * 4.4e-3) << tilt;
  }
}

TEST(Shank, ItsClearanceIsNeverOverestimated) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  int told = 0;
  for (const double band : {0.6, 1.0, 1.5, 3.0}) {
    for (const double diameter : {1.6_mm, 2.35_mm}) {
      Tool tool = bur_with_shank();
      tool.shank_diameter = diameter;
      HapticBench bench(fmt::format(R"({{"voxel_mm": 0.1, "band_mm": {}, "solids": [
        {{"tissue": "enamel", "solid": {{"box": {{"center_mm": [5, 0, 6], "size_mm": [5, 16, 6]}}}}}}]}})",
                                    band),
                        settings(tool));
      bench.tick({{-2.0_mm, 0, 0}});
      const haptics::TissuePatch& patch = bench.patch();
      const haptics::NonCuttingPart shank = *haptics::shank_of(tool);
      haptics::NonCuttingContacts contacts(tool, 0.1_mm);
      const VoxelFrame& frame = bench.settings.frame;
      for (int i = 0; i < 300; ++i) {
        const Pose X_WT{dvec3(any(random) * 1.0_mm, any(random) * 1.0_mm, any(random) * 1.0_mm),
                        glm::normalize(glm::angleAxis(0.3 * any(random), dvec3(0, 1, 0)))};
        const double room = contacts.clearance(patch, {frame.to_voxels(X_WT.p), X_WT.R});
        double clear = 1e9;  // m, of the shank's flank to the block's face and edges
        for (int k = 0; k <= 100; ++k) {
          const double u = k / 100.0 * shank.shape.length;
          const double radius = std::min(
              diameter / 2, tool.neck_diameter / 2 + (diameter - tool.neck_diameter) / 2 * u / tool.neck_length);
          const dvec3 p = X_WT * dvec3(0, 0, shank.z - shank.shape.length / 2 + u);
          const dvec3 off = glm::max(glm::abs(p - dvec3(5, 0, 6) * 1e-3) - dvec3(2.5, 8, 3) * 1e-3, dvec3(0));
          clear = std::min(clear, glm::length(off) - radius);
        }
        EXPECT_LE(room, std::max(clear / 0.1_mm, 0.0) + 1e-3) << band << " " << diameter << " " << i;
        told += room > 0.8;
      }
    }
  }
  EXPECT_GT(told, 1000);  // of 2400 poses, the number for which it reports room
}

TEST(Shank, ATickAllocatesNothing) {
  HapticBench bench(kWall, settings(bur_with_shank()));
  lean(bench, -0.6_mm, 0, 1);
  test::NoAlloc guard;
  ServoTick out;
  Cut cut;
  for (int i = 0; i < 100; ++i) bench.servo.tick({bench.t + i * 1'000'000, {{-0.6_mm, 0, i * 1e-7}}, 0, 0}, out, cut);
  EXPECT_EQ(guard.count(), 0u);
}

TEST(SafeEnd, RestsOnTheFloorWhileTheFlankCuts) {
  Tool tool;
  tool.shape = HeadShape::kCylinder;
  tool.diameter = 1.0_mm;
  tool.length = 3.0_mm;
  tool.safe_diameter = 0.8_mm;
  tool.safe_length = 0.4_mm;
  constexpr const char* kBlock =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 8]}}}]})";
  HapticBench bench(kBlock, settings(tool, 2));
  double z = 6.2_mm;
  for (int i = 0; i < 1500; ++i) {  // pressed down: the pin of 0.4 mm holds
    z = std::max(z - 2e-6, 5.5_mm);
    bench.tick({{0, 0, z}}, 1);
  }
  EXPECT_EQ(total(bench.last.removed), 0);
  EXPECT_NEAR(bench.last.X_WG.p.z, 4.0_mm + 0.4_mm + 1.5_mm, 5e-6);
  EXPECT_NEAR(bench.last.f_T_W.z, 0.5 * 0.4, 0.01);  // dentin
}

TEST(Shank, IsReadFromAToolFileAndRefusedIfImpossible) {
  const Tool tool = haptics::read_tool(Json::parse(
      R"({"shape": "sphere", "diameter_mm": 1.2, "shank": {"diameter_mm": 1.6, "neck_mm": 0.8, "taper_mm": 5, "length_mm": 8},
          "safe_end": {"diameter_mm": 0.5, "length_mm": 0.3}})",
      "tool"));
  EXPECT_DOUBLE_EQ(tool.shank_length, 8e-3);
  EXPECT_DOUBLE_EQ(tool.neck_length, 5e-3);
  EXPECT_DOUBLE_EQ(tool.safe_length, 0.3e-3);
  EXPECT_THROW(
      haptics::read_tool(Json::parse(R"({"shape": "sphere", "diameter_mm": 1.2, "shank": {"length_mm": 8}})", "tool")),
      Error);
  EXPECT_THROW(
      haptics::read_tool(Json::parse(R"({"shape": "sphere", "diameter_mm": 1.2, "shank": {"neck_mm": 0.5}})", "tool")),
      Error);
}

}  // namespace
}  // namespace typodont
