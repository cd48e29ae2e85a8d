// An exercise made in the window is a scene like any other.
#include <gtest/gtest.h>

#include "engine/app/operator/exercise.h"
#include "engine/app/operator/library.h"
#include "engine/base/units.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

constexpr const char* kBase = R"({"name": "block", "tissue": {"voxel_mm": 0.1, "solids": [
 {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [6, 6, 6]}}}]}, "tool": "round_012"})";

struct Exercise : testing::Test {
  test::ProgramFolder folder{""};
  void SetUp() override { setenv("TYPODONT_HOME", folder.path().c_str(), 1); }
  void TearDown() override { unsetenv("TYPODONT_HOME"); }
};

TEST_F(Exercise, HoldsWhatWasPaintedWhereItWasPainted) {
  const Scene base = parse_scene(Json::parse(kBase, "base.json"), folder / "base.json");
  const std::vector<PaintStroke> strokes = {{Tissue::kCaries, {0, 0, 2e-3}, {0, 0, 2e-3}, 1e-3},
                                            {Tissue::kCaries, {0, 0, 2e-3}, {1e-3, 0, 2e-3}, 1e-3}};
  const auto file = write_exercise({.name = "My caries", .goal = "Take it out.", .base = &base, .strokes = strokes});
  EXPECT_EQ(file, folder.path() / "scenes/my_caries.json");

  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.name, "My caries");
  const double painted = load_tissue(scene).volumes()[static_cast<std::size_t>(Tissue::kCaries)];
  // A ball swept by its radius: 4/3 π + π mm³.
  EXPECT_NEAR(painted / kCubicMillimetre, (4.0 / 3 + 1) * kPi, 0.3);

  std::vector<std::filesystem::path> pictures;
  bool found = false;
  for (const SceneChoice& choice : find_scenes({}, pictures))
    found = found || (choice.file == file && choice.own && choice.fault.empty());
  EXPECT_TRUE(found) << "it is there to be chosen";
}

TEST_F(Exercise, WhatIsChosenIsRememberedAndSpoiltMemoryIsForgotten) {
  EXPECT_FALSE(remembered().any);
  remember({.language = "de", .trainee = "Zoë \"Z\"", .record = false});
  const Remembered r = remembered();
  EXPECT_TRUE(r.any);
  EXPECT_EQ(r.language, "de");
  EXPECT_EQ(r.trainee, "Zoë \"Z\"");
  EXPECT_FALSE(r.record);
  folder.write("settings.json", "{\"language\": 3");
  EXPECT_FALSE(remembered().any);
}

TEST_F(Exercise, ATraineesNameCannotLeadOutOfTheFolder) {
  const auto file = new_session_file("../../etc/x", "a/b");
  EXPECT_EQ(file.parent_path().parent_path(), folder.path() / "sessions") << file;
  EXPECT_EQ(new_session_file("", "a").parent_path().filename(), "guest");
}

}  // namespace
}  // namespace typodont
