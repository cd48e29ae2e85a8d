// `typodont case` as users run it.
#include <gmock/gmock.h>

#include <filesystem>
#include <set>

#include "engine/app/assets.h"
#include "engine/app/cases/case.h"
#include "engine/app/task/task.h"
#include "engine/base/json.h"
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
                                           {"explore-caries", "1"}}) {
    const std::string name = family, file = folder / (name + ".json");
    const Ran made = run(name + " --seed 1 --difficulty " + difficulty + " --json --out " + file);
    ASSERT_EQ(made.status, 0) << name << made.err;
    const Json summary = Json::parse(made.out, "stdout");
    EXPECT_GE(summary["expert_points"].number(), 95) << name;
    EXPECT_LE(summary["careless_points"].number(), 60) << name;
    const Scene scene = read_scene(file);
    EXPECT_TRUE(scene.task && (scene.task->ideal || scene.task->explore)) << name;
  }
}

TEST_F(CaseCommand, EachFamilyHasTextsInThreeLanguagesAndASourceForEachParameter) {
  const Json table = Json::load(assets_folder() / "cases" / "families.json")["families"];
  const std::vector<CaseFamily> families = case_families();
  EXPECT_GE(families.size(), 24u);
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
  fails(out, "--list");
  fails("class-1 --list", "--list");
}

TEST_F(CaseCommand, TheListNamesEachFamilyWithItsTeethAndParameters) {
  const Ran listed = run("--list");
  EXPECT_EQ(listed.status, 0);
  EXPECT_THAT(listed.out, HasSubstr("class-1: Class I cavity; teeth U4"));
  EXPECT_THAT(listed.out, HasSubstr("access-molar"));
  EXPECT_THAT(listed.out, HasSubstr("pulp_left_mm"));
}

}  // namespace
}  // namespace typodont
