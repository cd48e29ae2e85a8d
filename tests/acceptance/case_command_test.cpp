// `typodont case` as users run it.
#include <gmock/gmock.h>

#include <filesystem>

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

TEST_F(CaseCommand, EachFamilyGivesASceneWhoseExactPlanPassesAndWhoseCarelessHandFails) {
  for (const CaseFamily& made_by : case_families()) {
    const std::string& family = made_by.name;
    const Ran made = run(family + " --seed 1 --difficulty 0.3 --json --out " + (folder / (family + ".json")));
    ASSERT_EQ(made.status, 0) << family << made.err;
    const Json summary = Json::parse(made.out, "stdout");
    EXPECT_GE(summary["expert_points"].number(), 95) << family;
    EXPECT_LE(summary["careless_points"].number(), 60) << family;
    const Scene scene = read_scene(folder / (family + ".json"));
    EXPECT_TRUE(scene.task && scene.task->ideal) << family;
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
