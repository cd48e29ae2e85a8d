// `typodont case` as users run it.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "engine/app/assets.h"
#include "engine/app/cases/case.h"
#include "engine/app/recording/resume.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/json.h"
#include "engine/base/voxels.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using ::testing::HasSubstr;

class CaseCommand : public ::testing::Test {
 protected:
  Ran run(const std::string& arguments) const { return folder.run("case " + arguments); }
  ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(CaseCommand, EqualSeedsGiveEqualFilesAndOtherSeedsOtherTeeth) {
  ASSERT_EQ(run("class-1 --seed 3 --difficulty 0.5 --out " + (folder / "a.json")).status, 0);
  const std::string scene = read_text(folder / "a.json");
  const std::uint64_t tissue = load_untouched(read_scene(folder / "a.json")).hash();
  ASSERT_EQ(run("class-1 --seed 3 --difficulty 0.5 --out " + (folder / "a.json")).status, 0);
  EXPECT_EQ(read_text(folder / "a.json"), scene);
  EXPECT_EQ(load_untouched(read_scene(folder / "a.json")).hash(), tissue);
  ASSERT_EQ(run("class-1 --seed 4 --difficulty 0.5 --out " + (folder / "b.json")).status, 0);
  EXPECT_NE(load_untouched(read_scene(folder / "b.json")).hash(), tissue);
}

// One family of each recipe that takes only seconds, easy and hard; `./run cases` makes all.
TEST_F(CaseCommand, EachRecipeGivesASceneWhoseExactPlanPassesAndWhoseCarelessHandFails) {
  struct Made {
    const char *family, *difficulty;
  };
  const std::vector<CaseFamily> families = case_families();
  for (const auto& [family, difficulty] : {Made{"fissure-opening", "0"},
                                           {"amalgam-removal", "1"},
                                           {"caries", "0.5"},
                                           {"caries-approximal", "1"},
                                           {"access-calcified", "0"},
                                           {"access-front", "1"},
                                           {"class-3", "0.5"},
                                           {"class-4", "1"},
                                           {"root-caries", "0"},
                                           {"crown-zirconia", "0.3"},
                                           {"access-curved", "1"},
                                           {"calculus", "0.5"},
                                           {"implant-molar", "0"},
                                           {"probing", "1"},
                                           {"explore-caries", "1"}}) {
    const std::string name = family, file = folder / (name + ".json");
    const Ran made = expect_ok(run(name + " --seed 1 --difficulty " + difficulty + " --json --out " + file));
    const Json summary = Json::parse(made.out, "stdout");
    EXPECT_GE(summary["expert_points"].number(), 95) << name;
    EXPECT_LE(summary["careless_points"].number(), 60) << name;
    const Scene scene = read_scene(file);
    EXPECT_TRUE(scene.task && (scene.task->ideal || scene.task->explore || scene.implant)) << name;
    // The skills that a family trains follow from the items of its score.
    const auto made_by = std::ranges::find(families, name, &CaseFamily::name);
    const bool caries = load_untouched(scene).volumes()[static_cast<std::size_t>(Tissue::kCaries)] > 0;
    EXPECT_EQ(made_by->weights.contains("residual_caries_percent"), caries && !scene.task->explore) << name;
    const std::optional<CaseIdentity> identity = case_in(Json::load(file));
    ASSERT_TRUE(identity) << name;
    EXPECT_EQ(identity->icdas > 0, summary["parameters"].has("icdas")) << name;
    EXPECT_EQ(identity->icdas > 0, made_by->weights.contains("residual_caries_percent") && name != "amalgam-removal")
        << name;
    const bool neighbours = scene.surroundings && !scene.surroundings->neighbours.empty();
    EXPECT_EQ(made_by->weights.contains("neighbour_removed_mm3"), neighbours) << name;
    if (!neighbours) continue;
    const auto around = surroundings_shape(scene.surroundings);
    for (const NeighbourTooth& neighbour : scene.surroundings->neighbours) {
      // Tooth and neighbour touch and do not overlap; behind the canine, both point to the middle of Monson's sphere.
      EXPECT_LT(std::abs(around->tooth(neighbour.contact)), 0.06e-3) << name;
      EXPECT_LT(std::abs(around->neighbour(neighbour.contact)), 0.06e-3) << name;
      const std::string tooth = summary["tooth"].string();
      const dvec3 sphere = dvec3(6.9e-3, 5.5e-3, 20e-3) + dvec3(0, 0, tooth[0] == 'L' ? 101.6e-3 : -101.6e-3);
      if (tooth[1] > '3') {
        EXPECT_LT(std::abs(glm::dot(sphere - neighbour.contact, neighbour.normal)), 0.5e-3) << name;
        EXPECT_GT(std::abs(neighbour.normal.z), 0.02) << name;
      }
      for (dvec3 d(-2e-3); d.z < 2e-3; d.z += 0.25e-3)
        for (d.y = -2e-3; d.y < 2e-3; d.y += 0.25e-3)
          for (d.x = -0.5e-3; d.x < 0.5e-3; d.x += 0.05e-3) {
            const dvec3 p = neighbour.contact + d;
            EXPECT_GT(std::max(around->tooth(p), around->neighbour(p)), -0.06e-3) << name;
          }
    }
    bool sound = true;  // a neighbour copies the tooth, but not its lesion
    for (double y = 4e-3; y < 8e-3; y += 0.5e-3)
      for (const render::MeshUpdate& tile : around->section_face({0, 1, 0}, y, dvec3(0)))
        for (const render::Vertex& v : tile.vertices)
          for (const Tissue tissue : v.tissue) sound &= tissue != Tissue::kCaries;
    EXPECT_TRUE(sound) << name;
  }
}

TEST_F(CaseCommand, GumHidesTheCalculusOfADifficultCaseAndLeavesThatOfAnEasyCaseInView) {
  for (const bool difficult : {false, true}) {
    const std::string file = folder / "calculus.json";
    expect_ok(run(fmt::format("calculus --seed 2 --difficulty {:d} --out {}", difficult, file)));
    const Scene scene = read_scene(file);
    const auto around = surroundings_shape(scene.surroundings);
    ASSERT_TRUE(around && around->has_gum());
    const DenseCopy copy = dense_copy(load_tissue(scene));
    double all = 0, hidden = 0;  // voxels
    for_each_voxel(copy.field.size, [&](int x, int y, int z) {
      const std::size_t i = copy.field.at(x, y, z);
      if (copy.tissue[i] != Tissue::kComposite || copy.field.distance[i] > 0) return;
      const dvec3 p = copy.frame.to_world(dvec3(x, y, z));
      if (around->tooth(p) < 0) return;
      ++all, hidden += around->gum(p) < 0;
    });
    EXPECT_GT(all, 100);
    if (difficult)
      EXPECT_GT(hidden / all, 0.95);
    else
      EXPECT_LT(hidden / all, 0.5);
  }
}

TEST_F(CaseCommand, AScannedToothTakesThePlaceOfTheParametricOne) {
  const haptics::TissueVolume molar = load_untouched(read_scene("class-1-cavity"));
  for (const char* family : {"class-1", "caries"}) {
    const std::string file = folder / "scan.json";
    const Ran made = expect_ok(run(
        fmt::format("{} --scan class-1-cavity --tooth L6 --seed 1 --difficulty 0.3 --json --out {}", family, file)));
    const Json summary = Json::parse(made.out, "stdout");
    EXPECT_GE(summary["expert_points"].number(), 95) << family;
    EXPECT_LE(summary["careless_points"].number(), 60) << family;
    const auto is = load_untouched(read_scene(file)).volumes(), was = molar.volumes();
    double all = 0, all_was = 0;
    for (std::size_t t = 0; t < is.size(); ++t) all += is[t], all_was += was[t];
    EXPECT_NEAR(all / all_was, 1, 0.02) << family;
  }
}

TEST_F(CaseCommand, AHandWithoutErrorsGetsTheExactPlansPointsAndEachErrorLowersThem) {
  const std::string hands = folder.write(
      "hands.csv",
      "x_mm,y_mm,z_mm,tilt_x_deg,spread_mm,force_N,force_max_N\n0,0,0,0,0,0,0\n0,0.3,0,0,0,0,0\n0,0,-0.3,0,0,"
      "0,0\n0,0,0,10,0,0,0\n0,0,0,0,0.1,0,0\n0,0,0,0,0,4,9\n0.55,0.55,-0.5,0,0,0,0\n");
  const Ran made =
      expect_ok(run("class-1 --seed 1 --difficulty 0 --json --hands " + hands + " --out " + (folder / "hands.json")));
  const Json summary = Json::parse(made.out, "stdout");
  const std::vector<Json> scores = summary["hands"].items();
  ASSERT_EQ(scores.size(), 7u);
  const auto points = [&](std::size_t k) { return scores[k]["points"].number(); };
  EXPECT_EQ(points(0), summary["expert_points"].number());
  for (std::size_t k = 1; k < 6; ++k) EXPECT_LT(points(k), points(0) - 2) << k;
  EXPECT_EQ(points(6), summary["careless_points"].number());
  // The floor follows the displacement.
  const auto depth = [&](std::size_t k) { return scores[k]["items"]["floor_depth_mm"].number(); };
  EXPECT_NEAR(depth(2) - depth(0), 0.3, 0.05);
  const auto fails = [&](const std::string& arguments, const std::string& word) {
    const Ran failed = run(arguments + " --out " + (folder / "bad.json"));
    EXPECT_NE(failed.status, 0) << arguments;
    EXPECT_THAT(failed.err, HasSubstr(word)) << arguments;
  };
  fails("explore-caries --hands " + hands, "--hands");
  fails("class-1 --hands " + folder.write("bad.csv", "x_mm,y_mm,z_mm,spread_mm\n0,0,0,-1\n"), "spread_mm");
}

TEST_F(CaseCommand, EachFamilyHasTextsInThreeLanguagesAndASourceForEachParameter) {
  const Json table = Json::load(assets_folder() / "cases" / "families.json")["families"];
  const std::vector<CaseFamily> families = case_families();
  EXPECT_GE(families.size(), 34u);
  for (const CaseFamily& family : families) {
    const Json own = table[family.name];
    std::set<std::string> known{"tooth", "length_mm"};
    known.insert(family.parameters.begin(), family.parameters.end());
    for (const char* language : {"en", "de", "zh"}) {
      std::string goal = own["goal"][language].string();
      for (std::size_t at = 0; (at = goal.find('{', at)) != std::string::npos; ++at)
        EXPECT_TRUE(known.contains(goal.substr(at + 1, goal.find('}', at) - at - 1))) << family.name << goal;
      if (const auto title = own.find("title")) {
        EXPECT_NE((*title)[language].string(), "") << family.name;
      }
      if (const auto steps = own.find("steps")) {
        for (const Json& step : steps->items()) EXPECT_NE(step[language].string(), "") << family.name;
      }
    }
    for (const std::string& name : family.parameters) {
      if (!own.has("parameters") || !own["parameters"].has(name)) continue;  // it is that of the family `like`
      const Json parameter = own["parameters"][name];
      for (const char* end : {"easy", "hard"}) {
        const std::vector<double> range = parameter[end].numbers(2);
        EXPECT_LE(range[0], range[1]) << family.name << name;
      }
      EXPECT_NE(parameter["source"].string(), "") << family.name << name;
    }
  }
}

TEST_F(CaseCommand, EachStepThatAFamilyStatesNamesItsToolIfTheFamilyHasSeveral) {
  const Json table = Json::load(assets_folder() / "cases" / "families.json")["families"];
  for (const std::string& name : table.keys()) {
    const Json own = table[name];
    const bool one_tool = own.has("scene") && own["scene"].has("tool");
    if (const auto steps = own.find("steps")) {
      for (const Json& step : steps->items()) EXPECT_NE(step.has("tool"), one_tool) << name << step["en"].string();
    }
  }
}

TEST_F(CaseCommand, AWrongFamilyToothSeedOrDifficultyIsNamedAndLeavesNoFile) {
  const std::string out = " --out " + (folder / "bad.json");
  const auto fails = [&](const std::string& arguments, const std::string& word) {
    const Ran failed = run(arguments);
    EXPECT_NE(failed.status, 0) << arguments;
    EXPECT_THAT(failed.err, HasSubstr(word)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(folder / "bad.json"));
  };
  fails("class-9" + out, "class-1");
  fails("class-1 --tooth U1" + out, "L6");
  fails("class-1 --difficulty 1.5" + out, "--difficulty");
  fails("class-1 --seed -1" + out, "--seed");
  fails("class-1", "--out");
  fails("class-1 --scan class-1-cavity" + out, "--tooth");
  fails("class-1 --tooth L6 --scan arch-explore" + out, "tooth: found no such key");
  for (const char* family : {"onlay", "access-molar"})
    fails(family + std::string(" --tooth L6 --scan class-1-cavity") + out, family);
  fails(out, "--list");
  fails("class-1 --list", "--list");
}

TEST_F(CaseCommand, TheListNamesEachFamilyWithItsTeethAndParameters) {
  const Ran listed = expect_ok(run("--list"));
  EXPECT_THAT(listed.out, HasSubstr("class-1: Class I cavity; teeth U4"));
  EXPECT_THAT(listed.out, HasSubstr("access-molar"));
  EXPECT_THAT(listed.out, HasSubstr("pulp_left_mm"));
}

struct NextCommand : CaseCommand {
  Ran next(const std::string& arguments) const {
    return folder.run("next --language en --trainee Anna --sessions {}/sessions " + arguments,
                      "TYPODONT_HOME=" + (folder / "home"));
  }
  void SetUp() override { std::filesystem::create_directories(folder / "sessions/Anna"); }
};

TEST_F(NextCommand, ANewTraineeBeginsWithAnEasyCaseWithinTheTeachersLimits) {
  const std::string limits =
      folder.write("limits.json", R"({"families": ["access-front"], "min_difficulty": 0.2, "max_difficulty": 0.6})");
  const Ran chosen = expect_ok(next("--json --limits " + limits + " --out " + (folder / "case.json")));
  const Json json = Json::parse(chosen.out, "stdout");
  EXPECT_EQ(json["family"].string(), "access-front");
  EXPECT_EQ(json["difficulty"].number(), 0.2);
  EXPECT_EQ(json["sessions"].integer(), 0);
  EXPECT_THAT(json["reason"].string(), HasSubstr("Root canal access, front tooth, difficulty 0.20: the first case"));
  const auto made = case_in(Json::load(folder / "case.json"));
  ASSERT_TRUE(made);
  EXPECT_EQ(made->family, "access-front");
  EXPECT_EQ(made->difficulty, 0.2);
  EXPECT_EQ(static_cast<long long>(made->seed), json["seed"].integer());
  EXPECT_NO_THROW((void)read_scene(folder / "case.json"));
}

TEST_F(NextCommand, ItEstimatesMasteryFromRecordingsAndLeavesOutDamagedOnes) {
  ASSERT_EQ(run("access-front --seed 5 --difficulty 1 --out " + (folder / "sessions/Anna/case.json")).status, 0);
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,30,1,0,0,0,0\n0.2,0,0,30,1,0,0,0,0\n");
  const std::string recording = folder / "sessions/Anna/2026-01-01_10-00-00_access-front-5.h5";
  ASSERT_EQ(folder
                .run("servo " + (folder / "sessions/Anna/case.json") + " --hand " + (folder / "hand.csv") + " --out " +
                     recording)
                .status,
            0);
  folder.write("sessions/Anna/2026-01-02_10-00-00_broken.h5", read_text(recording).substr(0, 3000));
  folder.write("sessions/Anna/2026-01-03_10-00-00_noise.h5", "no session");
  const Ran chosen = expect_ok(next("--json"));
  EXPECT_THAT(chosen.err, HasSubstr("left out: " + (folder / "sessions/Anna/2026-01-03_10-00-00_noise.h5")));
  const Json json = Json::parse(chosen.out, "stdout");
  EXPECT_EQ(json["sessions"].integer(), 1);
  EXPECT_THAT(json["reason"].string(), HasSubstr("it trains your weakest skill"));
  std::map<std::string, Json> skills;
  for (const Json& skill : json["skills"].items()) skills.emplace(skill["name"].string(), skill);
  EXPECT_EQ(skills.at("caries")["sessions"].integer(), 0);
  EXPECT_EQ(skills.at("pulp")["sessions"].integer(), 1);
  EXPECT_LT(skills.at("pulp")["ability"].number(), -1) << "nothing was done, so the case gave no points";
  EXPECT_LT(skills.at("pulp")["standard_error"].number(), 0.8);
  EXPECT_EQ(next("--json").out, chosen.out) << "the cached score gives the same choice";
}

TEST_F(NextCommand, WrongLimitsAreNamed) {
  const auto fails = [&](const std::string& limits, const std::string& word) {
    expect_exit(next("--limits " + folder.write("limits.json", limits)), 2, word);
  };
  fails(R"({"families": ["class-9"]})", "class-9");
  fails(R"({"families": []})", "at least one family");
  fails(R"({"min_difficulty": 0.7, "max_difficulty": 0.2})", "max_difficulty");
  fails(R"({"max_difficulty": 2})", "max_difficulty");
  fails(R"({"easy": true})", "easy");
}

}  // namespace
}  // namespace typodont
