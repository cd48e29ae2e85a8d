// Tests hands that work through the real servo: a hand that scrapes with an edge, and a hand that knows the task.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/app/assets.h"
#include "engine/app/hands/expert_hand.h"
#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/session/task.h"
#include "tests/support/expert_session.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace literals;

/// Returns the volume (mm³) that an edge removes when it moves forwards and backwards over a block of this tissue.
/// `press_mm`: how deep it is pressed.
double scraped(const std::string& tissue, double press_mm, double reach_mm,
               const std::string& tool = R"({"shape": "sphere", "diameter_mm": 1, "scrapes": 0.5})") {
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write(
      "scene.json",
      fmt::format(
          R"({{"tissue": {{"voxel_mm": 0.1, "solids": [{{"tissue": "{}", "solid": {{"box": {{"size_mm": [6, 4, 3]}}}}}}]}},
      "tool": {}, "spindle_krpm": 0, "materials": {{"amalgam": {{"specific_energy_J_per_mm3": 0.02}}}}}})",
          tissue, tool));
  std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4,1,0,0,0,0\n";
  for (int i = 0; i < 20; ++i) {
    hand += fmt::format("{},{},0,{},1,0,0,0,0\n", 0.5 + 0.2 * i, (i % 2 ? 1 : -1) * reach_mm, 2.0 - press_mm);
  }
  folder.write("hand.csv", hand);
  const test::Ran ran = expect_ok(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/out.csv --json"));
  const Json removed = Json::parse(ran.out, "servo")["removed_mm3"];
  return removed.has(tissue) ? removed[tissue].number() : 0;
}

TEST(Scraping, CarvesSoftAmalgamAndHardlyScratchesEnamel) {
  const double amalgam = scraped("amalgam", 0.4, 1);
  EXPECT_GT(amalgam, 0.15);
  EXPECT_LT(scraped("enamel", 0.4, 1), 0.01 * amalgam);
}

TEST(Scraping, NeedsAForceAMotionAndACuttingEdge) {
  EXPECT_GT(scraped("amalgam", 0.4, 1), 1.5 * scraped("amalgam", 0.1, 1));
  EXPECT_LT(scraped("amalgam", 0.4, 0), 0.05);
  EXPECT_EQ(scraped("amalgam", 0.4, 1, R"({"shape": "sphere", "diameter_mm": 1, "cuts": false})"), 0);
}

/// bench_expert runs all shipped exercises.
class ExpertSession : public testing::TestWithParam<const char*> {};

TEST_P(ExpertSession, TheExpertsLoadsContactsAndTremorLieInThePublishedRangesAndItScores95PercentWithinFiveMinutes) {
  const test::ExpertResult worked = test::expert_session(GetParam(), 600);
  EXPECT_GE(worked.percent, 95) << worked.items;
  EXPECT_LT(worked.seconds, 300);
  EXPECT_LT(worked.decay_seen, 0.002);
  // docs/reality.md, "Hands"
  EXPECT_GE(worked.drill.force(), 0.34);
  EXPECT_LE(worked.drill.force(), 1.03);
  EXPECT_GE(worked.drill.contact(), 0.25);
  EXPECT_LE(worked.drill.contact(), 0.40);
  EXPECT_NEAR(worked.drill.contacts_per_second(), 1.36, 0.1);
  EXPECT_NEAR(worked.drill.tremor(), 31e-6, 10e-6);
  EXPECT_GT(worked.drill.tremor_peak(), 3);
  EXPECT_NEAR(worked.tremor, 38e-6, 8e-6);
}

INSTANTIATE_TEST_SUITE_P(Shipped, ExpertSession, testing::Values("tutorial", "molar-caries", "class-1-cavity"),
                         [](const auto& param) { return test::test_name(param.param); });

TEST(AmalgamFilling, ACarvedFillingScoresMoreThanAnUncarvedOneAndNoFillingScoresNothing) {
  const Scene scene = read_scene(assets_folder() / "scenes/amalgam-filling.json");
  const haptics::TissueVolume start = load_tissue(scene);
  const TaskEvaluator judge(scene, start);
  const auto percent = [&](const haptics::TissueVolume& after) {
    session::ScoreInput input;
    input.before = start.volumes();
    input.after = after.volumes();
    input.hand.time = 300;
    judge.judge(after, input);
    const session::Score score =
        session::score(input, session::rules_of_scene(Json::parse(scene.text, "scene"), input));
    return 100 * score.points / score.full;
  };
  // Carries out every plan exactly, without a servo.
  Expert expert(scene, start, kExactMargins);
  haptics::TissueVolume left = start.clone();
  std::optional<haptics::TissueVolume> uncarved;  // the tissue after the condenser alone
  std::ptrdiff_t drawn = 0;                       // strokes of an edge
  for (std::vector<ExpertLeg> legs; !(legs = expert.plan(left)).empty(); left = expert.planned().clone()) {
    const auto scrapes = std::count_if(legs.begin(), legs.end(),
                                       [](const ExpertLeg& leg) { return leg.kind == ExpertLeg::Kind::kScrape; });
    if (scrapes > 0 && !uncarved) uncarved = left.clone();
    drawn += scrapes;
  }
  ASSERT_TRUE(uncarved);
  EXPECT_GT(drawn, 50);
  const double carved = percent(left), filled = percent(*uncarved);
  fmt::print("amalgam-filling: contour {:.1f} %, filled and carved {:.1f} %, filled {:.1f} %\n",
             percent(*judge.ideal()), carved, filled);
  EXPECT_GT(percent(*judge.ideal()), 97);
  EXPECT_GT(carved, 95);
  EXPECT_GT(carved, filled + 5);
  EXPECT_LT(percent(start), 1);
}

/// A cup of 16 mm in a block of bone, with voxels of 0.8 mm, as a hip is reamed.
TEST(ExpertHand, InLargeVoxelsItFinishesAndPressesWithTheForceOfTheTask) {
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.8, "band_mm": 4, "solids": [
      {"tissue": "cancellous_bone", "solid": {"box": {"center_mm": [0, 0, -7], "size_mm": [24, 24, 14]}}}]},
      "tools": [{"name": "reamer 14 mm", "shape": "sphere", "diameter_mm": 14}], "spindle_krpm": 0.3,
      "coupling": {"stiffness_N_per_mm": 60, "damping_Ns_per_mm": 0.02}, "force_limit_N": 250, "parts": ["haptics"],
      "task": {"goal": "cut", "ideal": {"remove": [{"sphere": {"center_mm": [0, 0, 0], "radius_mm": 8}}]},
        "rules": [{"name": "over_cut_mm3", "target": 0, "tolerance": 400, "weight": 50},
                  {"name": "force_mean_N", "target": 60, "tolerance": 60, "weight": 0}]}})");
  const Scene scene = read_scene(folder.path() / "scene.json");
  const haptics::TissueVolume start = load_tissue(scene);
  SteppedSession session(scene, load_tissue(scene), 1000);
  PlanningExpert hand(scene, session.carver(), 1000);
  double greatest = 0;  // N
  while (session.advance(hand)) {
    if (to_seconds(session.last().t) > 300) throw RunFailure("the expert does not end");
    greatest = std::max(greatest, glm::length(session.last().f_T_W));
  }
  const double whole = 2.0 / 3 * kPi * std::pow(8.0_mm, 3),
               left = total(session.carver().volume().volumes()) - (total(start.volumes()) - whole);
  EXPECT_LT(std::abs(left), 0.06 * whole);
  EXPECT_GT(greatest, 60);
  EXPECT_LT(greatest, 250);
}

TEST(ExpertHand, AReamerOfTheCupsOwnSizeGoesStraightInAfterTheSmallerOnes) {
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.8, "band_mm": 4, "solids": [
      {"tissue": "cancellous_bone", "solid": {"box": {"center_mm": [0.3, 0.1, -7], "size_mm": [24, 24, 14]}}}]},
      "tools": [{"name": "reamer 16 mm", "shape": "sphere", "diameter_mm": 16},
                {"name": "reamer 12 mm", "shape": "sphere", "diameter_mm": 12}],
      "spindle_krpm": 0.3, "parts": ["haptics"],
      "task": {"goal": "cut", "ideal": {"remove": [{"sphere": {"center_mm": [0.3, 0.1, 0], "radius_mm": 8}}]}}})");
  const Scene scene = read_scene(folder.path() / "scene.json");
  const haptics::TissueVolume start = load_tissue(scene);
  Expert expert(scene, start, kExactMargins);
  std::vector<std::uint32_t> taken;
  for (const ExpertLeg& leg : expert.plan(start)) {
    if (leg.kind == ExpertLeg::Kind::kTake) taken.push_back(leg.tool);
    if (leg.kind != ExpertLeg::Kind::kCut) continue;
    EXPECT_NEAR(leg.to.p.x, 0.3_mm, 0.05_mm);
    EXPECT_NEAR(leg.to.p.y, 0.1_mm, 0.05_mm);
  }
  EXPECT_EQ(taken, (std::vector<std::uint32_t>{1, 0}));
  const double whole = 2.0 / 3 * kPi * std::pow(8.0_mm, 3);
  EXPECT_NEAR(total(start.volumes()) - total(expert.planned().volumes()), whole, 0.02 * whole);
}

TEST(ExpertHand, IsRefusedWithoutAnIdealOrASuitableTool) {
  const test::ProgramFolder folder(TYPODONT_PROGRAM);
  const auto refused = [&](const std::string& rest) {
    folder.write(
        "scene.json",
        R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [4, 4, 3]}}}]}, )" +
            rest + "}");
    const test::Ran ran = folder.run("servo {}/scene.json --hand expert: --out {}/out.h5");
    EXPECT_EQ(ran.status, 2) << ran.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.h5"));
    return ran.err;
  };
  EXPECT_NE(refused(R"("tool": "round_012")").find("ideal"), std::string::npos);
  EXPECT_NE(
      refused(
          R"("tool": "probe_who_621", "task": {"goal": "cut", "ideal": {"remove": [{"sphere": {"center_mm": [0,0,1.5], "radius_mm": 1}}]}})")
          .find("tools"),
      std::string::npos);
}

}  // namespace
}  // namespace typodont
