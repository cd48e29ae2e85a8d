// Scenes and hands on which a contact model was wrong once.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/folder.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using haptics::ServoSettings;
using test::HapticBench;
using ::testing::HasSubstr;

constexpr const char* kModels[] = {"offset", "voxel_penalty", R"({"packing": {"spheres": 2000}})", "mesh_lod",
                                   "vertex"};

std::string box(const char* size_mm, double voxel_mm, const char* more = "") {
  return fmt::format(
      R"({{"voxel_mm": {}, {} "solids": [{{"tissue": "enamel", "solid": {{"box": {{"size_mm": [{}]}}}}}}]}})", voxel_mm,
      more, size_mm);
}

ServoSettings with_head(ServoSettings settings, HeadShape shape, double diameter, double length) {
  settings.tool.shape = shape;
  settings.tool.diameter = diameter, settings.tool.length = length;
  return settings;
}

TEST(ContactCases, ASessionThatBeginsInTissueSaysSoAndCutsOnlyWhatItsMotorPaysFor) {
  for (const char* model : kModels) {
    HapticBench bench(box("12, 12, 10", 0.2),
                      with_head(test::drill_settings(model), HeadShape::kSphere, 8.0_mm, 8.0_mm));
    constexpr double kLongestPush = 10.0_mm;  // from the hand to the surface and on
    const ServoSettings& s = bench.settings;
    const double max_power =
        s.tool.cutting_coefficient * s.stiffness * kLongestPush * s.tool.radius() * s.spindle.free_speed;
    bench.tick({{0, 0, 3.0_mm}}, 1);
    EXPECT_TRUE(bench.last.faults & bits(Fault::kDeepPenetration)) << model;
    EXPECT_EQ(total(bench.last.removed), 0) << model;
    for (int i = 2; i <= 100; ++i) {
      bench.tick({{0, 0, 3.0_mm}}, 1);
      ASSERT_LE(30e9 * total(bench.last.removed), max_power * i * s.tick) << model << ", tick " << i;
    }
  }
}

TEST(ContactCases, ADrillThatBeginsBelowItsOwnBedIsLedOutAndThenDeepensIt) {
  ServoSettings settings = with_head(test::drill_settings("offset"), HeadShape::kCylinder, 4.2_mm, 12.0_mm);
  settings.stiffness = 3000;
  settings.spindle.free_speed = 0.8 * kKrpm;
  MaterialTable bone = test::plain_materials();
  bone[static_cast<std::size_t>(Tissue::kDentin)].specific_energy = 0.5e9;
  HapticBench bench(R"({"voxel_mm": 0.15, "solids": [{"tissue": "dentin", "solid": {"difference": [
                            {"box": {"center_mm": [0, 0, -8], "size_mm": [12, 12, 16]}},
                            {"cylinder": {"radius_mm": 2.1, "height_mm": 16}}]}}]})",
                    settings, bone);
  const double half = settings.tool.half();
  bench.tick({{0, 0, half - 8.65_mm}}, 1);
  int inside = 0;
  for (; bench.last.faults & bits(Fault::kDeepPenetration); ++inside) {
    ASSERT_EQ(total(bench.last.removed), 0);
    ASSERT_LT(inside, 100);
    bench.tick({{0, 0, bench.last.X_WG.p.z - 0.7_mm}}, 1);
  }
  EXPECT_GT(bench.last.X_WG.p.z, half - 8.02_mm);
  for (int i = 0; i < 2000; ++i) bench.tick({{0, 0, bench.last.X_WG.p.z - 0.7_mm}}, 1);
  EXPECT_LT(bench.last.X_WG.p.z, half - 8.01_mm);
  EXPECT_GT(total(bench.last.removed), 0.1e-9);
}

TEST(ContactCases, AHeadThatSurroundsTheTissueWhenASessionBeginsIsReported) {
  // An inverted cone and a cone over a small box, held as they were.
  const std::pair<HeadShape, double> heads[] = {{HeadShape::kInvertedCone, 21.2_mm}, {HeadShape::kCone, 31.0_mm}};
  for (const auto& [shape, length] : heads) {
    HapticBench bench(box("4.5, 4.5, 2.7", 0.1), with_head(test::probe_settings("vertex"), shape, 9.0_mm, length));
    EXPECT_TRUE(bench.tick({{0.5_mm, 0.3_mm, 5.0_mm}}).faults & bits(Fault::kDeepPenetration));
  }
}

TEST(ContactCases, TheRemovedVolumeNeverFallsWhileNothingIsFilled) {
  const std::string groove =
      R"({"voxel_mm": 0.3, "solids": [{"tissue": "enamel", "solid": {"difference": [{"box": {"size_mm": [9, 9, 5]}},
          {"box": {"center_mm": [0, 0, 2.5], "size_mm": [18, 1.5, 4]}}]}}]})";
  const std::string shell =
      R"({"voxel_mm": 0.15, "solids": [{"tissue": "enamel", "solid": {"difference": [{"sphere": {"radius_mm": 2.5}},
          {"sphere": {"radius_mm": 2.1}}]}}]})";
  const std::pair<std::string, HeadShape> scenes[] = {{groove, HeadShape::kRoundEndCylinder},
                                                      {shell, HeadShape::kSphere}};
  MaterialTable soft = test::plain_materials();
  soft[static_cast<std::size_t>(Tissue::kEnamel)].specific_energy = 0.5e9;
  for (const char* model : {"offset", "voxel_penalty", "mesh_lod", "vertex"}) {
    for (const auto& [tissue, shape] : scenes) {
      const double length = shape == HeadShape::kSphere ? 2.0_mm : 5.0_mm;
      HapticBench bench(tissue, with_head(test::drill_settings(model), shape, 2.0_mm, length), soft);
      const double top = bench.settings.tool.half() + 2.6_mm;
      PerTissue before{};
      for (int i = 0; i < 1500; ++i) {
        const double a = 0.004 * i;
        bench.tick({{1.5_mm * std::sin(a), 1.0_mm * std::sin(1.7 * a), top - 1.0_mm * std::sin(0.3 * a)}}, 1);
        for (std::size_t t = 1; t < before.size(); ++t) {
          ASSERT_GE(bench.last.removed[t], before[t]) << model << ", tick " << i;
        }
        before = bench.last.removed;
      }
      EXPECT_GT(total(before), 0) << model;
    }
  }
}

/// Moves the hand from place to place at constant speed.
struct Moves {
  HapticBench& bench;
  dvec3 at;
  double pedal = 1;
  double max_removed = 0, max_force = 0, min_force_z = 0;  // m³, N, N; in one tick
  int ticks = 0;

  void to(const dvec3& p, double seconds) {
    const int count = std::max(1, static_cast<int>(std::lround(seconds / bench.settings.tick)));
    const dvec3 from = at;
    for (int i = 1; i <= count; ++i, ++ticks) {
      const double removed = total(bench.last.removed);
      at = from + (p - from) * (static_cast<double>(i) / count);
      bench.tick({at}, pedal);
      max_removed = std::max(max_removed, total(bench.last.removed) - removed);
      max_force = std::max(max_force, glm::length(bench.last.f_T_W));
      min_force_z = std::min(min_force_z, bench.last.f_T_W.z);
    }
  }
};

HapticBench soft_block(ServoSettings settings, const char* tissue = "dentin") {
  settings.spindle.free_speed = 200 * kKrpm;
  MaterialTable materials = test::plain_materials();
  materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy = 1e9;
  materials[static_cast<std::size_t>(Tissue::kCaries)] = {300, 1e9, 0.5, 0.4, 2150, dvec3(0.4)};
  return {fmt::format(R"({{"voxel_mm": 0.1, "solids": [{{"tissue": "{}",
              "solid": {{"box": {{"center_mm": [0, 0, -2], "size_mm": [10, 8, 4]}}}}}}]}})",
                      tissue),
          settings, materials};
}

TEST(ContactCases, TwoEqualDipsRemoveTheSameAndNothingBetweenThem) {
  for (const char* model : {"offset", "mesh_lod", "vertex"}) {
    HapticBench bench = soft_block(test::drill_settings(model));
    Moves hand{bench, {-1.3_mm, 0, 3.6_mm}};
    double removed[2] = {};
    for (int dip = 0; dip < 2; ++dip) {
      const double x = dip == 0 ? -1.3_mm : 1.3_mm, before = total(bench.last.removed);
      hand.to({x, 0, 3.6_mm}, 1e-3);
      hand.to({x, 0, 0.7_mm}, 0.5);
      hand.to({x, 0, 0.3_mm}, 1.0);
      hand.to({x, 0, 0.3_mm}, 0.1);
      hand.to({x, 0, 3.6_mm}, 0.4);
      removed[dip] = total(bench.last.removed) - before;
    }
    EXPECT_GT(removed[0], 0.05e-9) << model;
    EXPECT_NEAR(removed[1], removed[0], 0.03 * removed[0]) << model;
    EXPECT_LT(hand.max_removed, 0.01e-9) << model;
  }
}

TEST(ContactCases, ABurThatStopsInItsOwnHoleComesOutFreely) {
  for (const char* model : {"offset", "mesh_lod", "vertex"}) {
    for (const HeadShape shape : {HeadShape::kSphere, HeadShape::kRoundEndCylinder}) {
      for (const double bur_mm : {0.6, 1.2}) {
        for (const double depth : {1.7, 2.0, 2.4}) {
          const double R = bur_mm / 2 * 1.0_mm, length = shape == HeadShape::kSphere ? 2 * R : 5 * R;
          ServoSettings settings = with_head(test::drill_settings(model), shape, 2 * R, length);
          HapticBench bench = soft_block(settings);
          const double half = settings.tool.half();
          Moves hand{bench, {0, 0, half + 0.1_mm}};
          hand.to({0, 0, half - depth * R}, depth * bur_mm);
          hand.to(hand.at, 0.2);
          hand.pedal = 0;
          hand.to(hand.at, 0.2);
          const std::string what = fmt::format("{}, {} {} mm, {}", model, static_cast<int>(shape), bur_mm, depth);
          EXPECT_LT(bench.last.X_WG.p.z, half - (depth - 0.4) * R) << what;
          EXPECT_GT(bench.last.X_WG.p.z, half - (depth + 0.1) * R) << what;
          hand.max_force = 0;
          hand.to(hand.at + dvec3(0.2 * R, 0, R), 0.3);
          hand.to({0, 0, half + 1.5_mm}, 0.5);
          EXPECT_LT(hand.max_force, 0.35) << what;
          EXPECT_EQ(glm::length(bench.last.f_T_W), 0) << what;
        }
      }
    }
  }
}

TEST(ContactCases, AProbeSinksIntoCariesWithoutAStepAndIsHeldWhenWithdrawnAndDoesNeitherInEnamel) {
  const auto pointed = [](const char* model) {
    ServoSettings settings = with_head(test::probe_settings(model), HeadShape::kSphere, 0.25_mm, 0.25_mm);
    settings.tool.cuts = false, settings.tool.sink_yield = 0.3;
    return settings;
  };
  HapticBench hard = soft_block(pointed("offset"), "enamel");
  Moves above{hard, {0, 0, 0.325_mm}};
  above.to({0, 0, -1.375_mm}, 1);
  EXPECT_GT(hard.last.X_WG.p.z, 0.124_mm);
  above.to({0, 0, 1.6_mm}, 1.5);
  EXPECT_GT(above.min_force_z, -1e-3);
  for (const char* model : {"offset", R"({"packing": {"spheres": 2000}})", "mesh_lod", "vertex"}) {
    HapticBench bench = soft_block(pointed(model), "caries");
    Moves hand{bench, {0, 0, 0.325_mm}};
    hand.to({0, 0, -1.375_mm}, 1);
    hand.to(hand.at, 0.5);
    EXPECT_LT(bench.max_step, 0.02) << model;
    hand.to({0, 0, 1.6_mm}, 1.5);
    EXPECT_LT(hand.max_force, 0.6) << model;
    EXPECT_LT(hand.min_force_z, -0.03) << model;
    EXPECT_EQ(bench.last.f_T_W, dvec3(0)) << model;
  }
}

TEST(ContactCases, MemoryFollowsTheTissueUnderALargeHead) {
  for (const char* model : {"offset", "voxel_penalty"}) {
    ServoSettings settings = with_head(test::probe_settings(model), HeadShape::kCylinder, 5.0_mm, 20.0_mm);
    settings.passivity = false;
    HapticBench bench(box("1, 1, 0.6", 0.04), settings);
    EXPECT_LT(bench.empty_patch().n, 128);
    // The flat end, and then the side, on the top.
    for (const bool lies : {false, true}) {
      const dquat R = lies ? glm::angleAxis(kPi / 2, dvec3(1, 0, 0)) : dquat(1, 0, 0, 0);
      const double at_top = (lies ? 2.5_mm : 10.0_mm) + 0.3_mm;
      for (double z = 30.0_mm; z > at_top + 1.0_mm; z -= 0.5_mm) bench.tick({{0, 0, z}, R});
      for (double z = at_top + 0.1_mm; z > at_top - 0.2_mm; z -= 5e-6) bench.tick({{0, 0, z}, R});
      for (int i = 0; i < 60; ++i) bench.tick({{0, 0, at_top - 0.2_mm}, R});
      if (std::string_view(model) == "offset") {  // the springs of voxel_penalty are farther apart than 1 mm
        EXPECT_NEAR(bench.last.f_T_W.z, 0.2, 1e-3);
        EXPECT_LT(std::hypot(bench.last.f_T_W.x, bench.last.f_T_W.y), 1e-4);
        EXPECT_NEAR(bench.last.X_WG.p.z, at_top, 1e-6);
      }
      for (double z = at_top; z < 30.0_mm; z += 0.5_mm) bench.tick({{0, 0, z}, R});
      EXPECT_EQ(bench.last.f_T_W, dvec3(0));
      EXPECT_EQ(bench.last.faults, 0u);
    }
  }
}

TEST(ContactCases, ASceneThatNeedsTooMuchMemoryIsRefusedWithTheKey) {
  EXPECT_THAT(test::refusal([&] {
                HapticBench bench(box("31, 0.3, 0.3", 0.05, "\"band_mm\": 0.2,"),
                                  with_head(test::probe_settings("offset"), HeadShape::kCylinder, 10.0_mm, 34.0_mm));
              }),
              testing::AllOf(HasSubstr("voxel_mm: found 0.05 mm with a head of 10 x 34 mm, which needs 5.4 GB"),
                             HasSubstr("expected at least 0.079 mm, or a smaller head")));
}

TEST(ContactCases, AHandThatJumpsThroughThinTissueLeavesTheProxyInFront) {
  const ServoSettings tip = with_head(test::probe_settings("mesh_lod"), HeadShape::kSphere, 0.25_mm, 0.25_mm);
  for (const ServoSettings& settings :
       {test::probe_settings("vertex"), tip, with_head(tip, HeadShape::kFlame, 1.0_mm, 3.0_mm)}) {
    HapticBench bench(box("10, 10, 0.8", 0.2), settings);
    for (int i = 0; i < 200; ++i) {
      bench.tick({{0, 0, i % 2 ? -7.0_mm : 5.0_mm}});
      ASSERT_GT(bench.last.X_WG.p.z, 0.4_mm) << settings.method->name() << ", tick " << i;
    }
  }
}

TEST(ContactCases, ParametersThatAModelLacksOrThatAreOutOfRangeAreRefusedWithAReason) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"vertex": {"edge": 1}})", "edge"},
      {R"({"vertex": {"edge_mm": 0}})", "edge_mm"},
      {R"({"mesh_lod": {"level": [10]}})", "level"},
      {R"({"mesh_lod": {"levels": [100, 200]}})", "no more vertices"},
      {R"({"mesh_lod": {"levels": []}})", "at least one"},
      {R"({"mesh_lod": {"switch_mm_s": [120, 30]}})", "rising"},
      {R"({"packing": {"spheres": 0}})", "spheres"},
      {R"({"packing": {"spheres": 1000000000}})", "spheres"},
      {R"({"packing": {"sphere": 10}})", "sphere"},
      {R"({"packing": {"density": {"stone": 1}}})", "stone"},
      {R"({"packing": {"file": "p.h5"}})", "file"},
      {R"({"offset": {"intermediate_surface": {"update_hz": 0.5}}})", "update_hz"},
      {R"({"offset": {"intermediate_surface": {"mm3_per_N_s": 0}}})", "mm3_per_N_s"},
      {R"({"offset": {"intermediate_surface": {"max_mm_per_s": -1}}})", "max_mm_per_s"},
      {R"({"offset": {"intermediate_surface": {"hz": 30}}})", "hz"}};
  for (const auto& [json, part] : cases) {
    EXPECT_THAT(test::refusal([&] { haptics::read_contact_method(Json::parse(json, "model")); }), HasSubstr(part))
        << json;
  }
}

TEST(ContactCases, AModelThatCannotFillRefusesAToolThatFills) {
  for (const char* model : {R"({"packing": {"spheres": 200}})", "mesh_lod", "vertex"}) {
    ServoSettings settings = test::probe_settings(model);
    settings.tool.cuts = false, settings.tool.fill = Tissue::kComposite;
    EXPECT_THROW(HapticBench(box("4, 4, 4", 0.2), settings), Error) << model;
  }
}

TEST(ContactCases, APackingFinerThanItsVoxelsIsRefusedWithItsLimit) {
  const std::string said = test::refusal([&] {
    HapticBench bench(box("0.3, 0.3, 0.72", 0.3), test::probe_settings(R"({"packing": {"spheres": 2000}})"));
  });
  EXPECT_THAT(said, HasSubstr("packing: spheres: found 2000, expected at most 153, 64 in each voxel of tissue"));
}

}  // namespace
}  // namespace typodont
