// `typodont case` as users run it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "engine/app/task/task.h"
#include "engine/base/json.h"

namespace typodont {
namespace {

using ::testing::HasSubstr;

class CaseCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("typodont_case_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  struct Result {
    int status;
    std::string out, err;
  };
  Result run(const std::string& arguments) {
    const std::string line =
        std::string(TYPODONT_PROGRAM) + " case " + arguments + " > " + path("stdout") + " 2> " + path("stderr");
    const int status = std::system(line.c_str());
    return {WEXITSTATUS(status), read(path("stdout")), read(path("stderr"))};
  }
  std::string path(const std::string& name) { return (folder_ / name).string(); }
  std::string read(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::filesystem::path folder_;
};

TEST_F(CaseCommand, EqualSeedsGiveEqualFilesAndOtherSeedsOtherTeeth) {
  ASSERT_EQ(run("class-1 --seed 3 --difficulty 0.5 --out " + path("a.json")).status, 0);
  const std::string scene = read(path("a.json"));
  const std::uint64_t tissue = load_untouched(read_scene(path("a.json"))).hash();
  ASSERT_EQ(run("class-1 --seed 3 --difficulty 0.5 --out " + path("a.json")).status, 0);
  EXPECT_EQ(read(path("a.json")), scene);
  EXPECT_EQ(load_untouched(read_scene(path("a.json"))).hash(), tissue);
  ASSERT_EQ(run("class-1 --seed 4 --difficulty 0.5 --out " + path("b.json")).status, 0);
  EXPECT_NE(load_untouched(read_scene(path("b.json"))).hash(), tissue);
}

TEST_F(CaseCommand, EachFamilyGivesASceneWhoseExactPlanPassesAndWhoseCarelessHandFails) {
  for (const std::string family : {"class-1", "caries", "access-molar"}) {
    const Result made = run(family + " --seed 1 --difficulty 0.3 --json --out " + path(family + ".json"));
    ASSERT_EQ(made.status, 0) << family << made.err;
    const Json summary = Json::parse(made.out, "stdout");
    EXPECT_GE(summary["expert_points"].number(), 95) << family;
    EXPECT_LE(summary["careless_points"].number(), 60) << family;
    const Scene scene = read_scene(path(family + ".json"));
    EXPECT_TRUE(TaskEvaluator(scene, load_untouched(scene)).has_ideal()) << family;
  }
}

TEST_F(CaseCommand, AWrongFamilyToothSeedOrDifficultyIsNamedAndLeavesNoFile) {
  const std::string out = " --out " + path("bad.json");
  const auto fails = [&](const std::string& arguments, const std::string& word) {
    const Result failed = run(arguments);
    EXPECT_NE(failed.status, 0) << arguments;
    EXPECT_THAT(failed.err, HasSubstr(word)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(path("bad.json")));
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
  const Result listed = run("--list");
  EXPECT_EQ(listed.status, 0);
  EXPECT_THAT(listed.out, HasSubstr("class-1: Class I cavity; teeth U4"));
  EXPECT_THAT(listed.out, HasSubstr("access-molar"));
  EXPECT_THAT(listed.out, HasSubstr("pulp_left_mm"));
}

}  // namespace
}  // namespace typodont
