// Tests the common interface of contact methods, the example outside the library, and the model "voxel_penalty".
#include <gmock/gmock.h>

#include <cmath>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact_method.h"
#include "tests/support/folder.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::contact_method;
using test::drill_settings;
using test::HapticBench;
using test::probe_settings;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::string_view kBall =
    R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 4}}}]})";
constexpr std::string_view kBlock =
    R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]})";

/// Returns the largest angle (degrees) between the force and the normal of a ball on which the hand slides at a depth
/// of 0.2 mm.
double direction_error(const char* model) {
  HapticBench bench(kBall, probe_settings(model));
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const double a = 0.3 + 0.004 * i;
    const dvec3 way(std::cos(a), 0.4, std::sin(a));
    const dvec3 n = glm::normalize(way);
    bench.tick({(i == 0 ? 6.0_mm : 4.4_mm) * n});
    if (i < 40) continue;
    const dvec3 f = bench.last.f_model_W;  // after the leap, the passivity controller makes f_T_W almost zero
    EXPECT_GT(glm::length(f), 0.1) << model << ", " << i;
    worst = std::max(worst, std::acos(std::min(1.0, glm::dot(glm::normalize(f), n))) * 180 / kPi);
  }
  return worst;
}

TEST(ContactMethods, AMethodFromAnotherFileIsChosenByNameWithItsParameters) {
  EXPECT_THAT(haptics::contact_method_names(), Contains("ball"));
  haptics::ServoSettings settings = probe_settings("ball");
  settings.method = haptics::read_contact_method(Json::parse(R"({"ball": {"radius_mm": 3}})", "scene"));
  EXPECT_EQ(settings.method->name(), "ball");
  HapticBench bench(kBall, settings);
  for (int i = 0; i <= 200; ++i) bench.tick({{0, 0, 3.8_mm - 2e-6 * i}});
  for (int i = 0; i < 50; ++i) bench.tick({{0, 0, 3.4_mm}});
  EXPECT_NEAR(bench.last.f_T_W.z, 1000 * 0.2_mm, 1e-12) << "spring of 1 N/mm, 0.2 mm deep in a ball of 3 mm";
  EXPECT_EQ(bench.last.tissue, Tissue::kEnamel);
}

TEST(ContactMethods, AnUnknownNameIsRefusedWithTheListOfNames) {
  EXPECT_THAT(
      test::refusal([&] { contact_method("nonsense", "--model"); }),
      testing::AllOf(HasSubstr("nonsense"), HasSubstr("offset, implant, mesh_lod, packing, vertex, voxel_penalty")));
  EXPECT_THROW(haptics::read_contact_method(Json::parse(R"({"offset": {}, "ball": {}})", "scene")), Error);
  EXPECT_THROW(haptics::read_contact_method(Json::parse(R"({"voxel_penalty": {"samples": 4}})", "scene")), Error);
  EXPECT_THROW(haptics::read_contact_method(Json::parse(R"({"voxel_penalty": {"sample": 64}})", "scene")), Error);
  EXPECT_THROW(haptics::read_contact_method(Json::parse("3", "scene")), Error);
}

TEST(ContactMethods, GodObjectIsAnotherNameOfOffset) {
  EXPECT_EQ(contact_method("god-object", "test")->name(), "offset");
}

TEST(ContactMethods, EqualHandsGetEqualBitsAndNoTickAllocates) {
  haptics::Tool cylinder;
  cylinder.shape = haptics::HeadShape::kCylinder, cylinder.diameter = 1.0_mm, cylinder.length = 3.0_mm;
  constexpr std::string_view kGraded = R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}},
      {"tissue": "dentin", "hardness": 0.5, "solid": {"box": {"center_mm": [1.5, 0, 0], "size_mm": [3, 6, 4]}}}]})";
  for (const char* model :
       {"offset", "vertex", "voxel_penalty", "ball", R"({"packing": {"spheres": 2000, "tool_spheres": 30}})",
        R"({"mesh_lod": {"vertices": 2000, "levels": [2000, 800]}})"}) {
    for (const bool round : {true, false}) {
      haptics::ServoSettings settings = drill_settings(model);
      if (!round) settings.tool = cylinder;
      HapticBench first(round ? kGraded : kBlock, settings), second(round ? kGraded : kBlock, settings);
      for (int i = 0; i < 700; ++i) {
        const Pose hand{{0.1_mm * std::sin(0.02 * i), 0, 2.1_mm + settings.tool.half() - 1e-6 * i},
                        glm::angleAxis(round ? 0 : 1e-4 * i, dvec3(0, 1, 0))};
        std::size_t allocated = 0;
        for (HapticBench* bench : {&first, &second}) {
          if (i < 400) {
            bench->tick(hand, 1);
            continue;
          }
          test::NoAlloc guard;
          bench->servo.tick({bench->t += 1'000'000, hand, 1}, bench->last, bench->cut);
          allocated += guard.count();
        }
        ASSERT_EQ(allocated, 0u) << model << ", tick " << i;
        ASSERT_EQ(first.last.f_T_W, second.last.f_T_W) << model << ", tick " << i;
        ASSERT_EQ(first.last.X_WG.p, second.last.X_WG.p) << model << ", tick " << i;
        ASSERT_EQ(first.last.removed, second.last.removed) << model << ", tick " << i;
      }
      EXPECT_EQ(first.last.cuts > 0, model != std::string_view("ball")) << model;
      EXPECT_EQ(first.carver.volume().hash(), second.carver.volume().hash()) << model;
    }
  }
}

TEST(VoxelPenalty, ItsDirectionHasErrorsOfDegreesWhereTheOffsetSurfaceIsExact) {
  EXPECT_LT(direction_error("offset"), 1e-2);
  const double error = direction_error("voxel_penalty");
  EXPECT_GT(error, 2.0) << "a yardstick as good as this would be no yardstick";
  EXPECT_LT(error, 20.0);
}

TEST(VoxelPenalty, TheTorqueIsTheSumOfTheSamplesLeverTimesForce) {
  // A cylinder lies flat on the edge of a block, with its middle 1 mm beyond the edge. So the block pushes only
  // on one half of the cylinder.
  haptics::ServoSettings settings = probe_settings("voxel_penalty");
  settings.tool.shape = haptics::HeadShape::kCylinder;
  settings.tool.diameter = 1.0_mm;
  settings.tool.length = 4.0_mm;
  HapticBench bench(kBlock, settings);
  const Pose lying{{4.0_mm, 0, 2.4_mm}, rotation_between(dvec3(0, 0, 1), dvec3(1, 0, 0))};
  for (int i = 200; i >= 0; --i) bench.tick({lying.p + dvec3(0, 0, 2e-6 * i), lying.R});
  for (int i = 0; i < 50; ++i) bench.tick(lying);
  const ServoTick& tick = bench.last;
  ASSERT_GT(tick.f_T_W.z, 1e-3);
  const double lever = tick.tau_T_W.y / tick.f_T_W.z;  // τ_y = -x f_z of a push at x < 0 from the head's centre
  EXPECT_GT(lever, 1.0_mm);
  EXPECT_LT(lever, 2.0_mm) << "between the block's edge and the cylinder's end";
}

constexpr std::string_view kEnamelBlock =  // 1 N/mm
    R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [6, 6, 4]}}}]})";

/// Returns the force (N) of a block, whose top is at z = 2 mm, on a ball of 1.2 mm that is pressed in by `pressed_mm`.
double pushed_back(double pressed_mm) {
  HapticBench bench(kEnamelBlock, probe_settings("voxel_penalty"));
  for (int i = 0; i <= 200; ++i) bench.tick({{0.03_mm, 0.04_mm, 2.6_mm - pressed_mm * 1.0_mm * i / 200.0}});
  return bench.last.f_model_W.z;
}

TEST(VoxelPenalty, AWallHasTheScenesStiffnessUpToADepthOfTheHeadsRadius) {
  for (const double mm : {0.3, 0.4, 0.5}) EXPECT_NEAR(pushed_back(mm), mm, 0.15 * mm) << mm << " mm at 1 N/mm";
}

// Without a proxy, a penalty model holds a head only up to a depth of about the head's radius. At larger depths, the
// samples on the far side push the head forward.
TEST(VoxelPenalty, HoldsNoMoreThanItsStiffnessTimesTheHeadsRadius) {
  double most = 0;
  for (double mm = 0.1; mm < 1.3; mm += 0.1) most = std::max(most, pushed_back(mm));
  EXPECT_NEAR(most, 0.6, 0.12) << "1 N/mm times 0.6 mm";
  EXPECT_LT(pushed_back(1.0), 0.85 * most) << "deeper in it pushes back less: a push of 1 N comes through";
}

TEST(VoxelPenalty, RemovedVolumeEqualsTheSpentEnergy) {
  HapticBench bench(kBlock, drill_settings("voxel_penalty"));
  double work = 0;
  for (int i = 0; i < 3000; ++i) {
    bench.tick({{0.3_mm * std::sin(0.01 * i), 0, 2.62_mm - 0.3e-6 * i}}, 1);
    work += bench.last.cutting_power * bench.settings.tick;
  }
  const double dentin = 8e9;  // J/m³ of plain_materials()
  EXPECT_NEAR(work / dentin, total(bench.last.removed), 0.01 * total(bench.last.removed));
}

TEST(VoxelPenalty, AToolThatFillsIsRefusedWithTheReason) {
  haptics::ServoSettings settings = probe_settings("voxel_penalty");
  settings.tool.fill = Tissue::kAmalgam;
  settings.tool.fill_rate = 1e-9;
  settings.tool.fill_reach = 0.5e-3;
  EXPECT_THROW(HapticBench(kBlock, settings), Error);
}

}  // namespace
}  // namespace typodont
