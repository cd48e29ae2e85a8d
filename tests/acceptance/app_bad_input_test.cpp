// Tests bad input through the command line: the exit status is 2, the message states file, position, found and expected
// value, and no files remain.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kScene = R"({"tissue": {"voxel_mm": 0.2, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": {"shape": "sphere", "diameter_mm": 1.0}})";
constexpr const char* kHand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,0\n0.01,0,0,5,1,0,0,0,0\n";

class BadInput : public testing::Test {
 protected:
  BadInput() {
    folder.write("scene.json", kScene);
    folder.write("hand.csv", kHand);
  }
  void refuse(const std::string& arguments, const testing::Matcher<std::string>& message) {
    const Ran ran = folder.run(arguments);
    EXPECT_EQ(ran.status, 2) << arguments << "\n" << ran.err;
    EXPECT_THAT(ran.err, message) << arguments;
    EXPECT_EQ(ran.out, "") << arguments;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv")) << arguments;
  }
  std::string servo(const std::string& scene, const std::string& hand) {
    return fmt::format("servo {0}/{1} --hand {0}/{2} --out {0}/out.csv", folder.path().string(), scene, hand);
  }
  ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(BadInput, ANaNInAHandIsNamedByLineAndColumn) {
  folder.write("nan.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,0\n0.1,0,nan,5,1,0,0,0,0\n");
  refuse(servo("scene.json", "nan.csv"), AllOf(HasSubstr("nan.csv: line 3, column y_mm"), HasSubstr("found \"nan\""),
                                               HasSubstr("expected a finite number")));
}

TEST_F(BadInput, TimeThatRunsBackwardsIsRefusedWithItsLine) {
  folder.write("back.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,0\n-1,0,0,5,1,0,0,0,0\n");
  refuse(servo("scene.json", "back.csv"),
         AllOf(HasSubstr("line 3, column t_s"), HasSubstr("found -1"), HasSubstr("more than 0")));
}

TEST_F(BadInput, AnUnknownKeyIsNamedWithTheKnownOnes) {
  folder.write("key.json", R"({"tissue": {"voxel_mm": 0.2, "solids": []}, "tool": "round_012", "colour": 3})");
  refuse(servo("key.json", "hand.csv"),
         AllOf(HasSubstr("key.json: line 1, \"colour\""), HasSubstr("unknown key"), HasSubstr("tissue")));
}

TEST_F(BadInput, AnUnknownToolIsRefusedWithTheListOfKnownTools) {
  folder.write("tool.json", R"({"tissue": {"voxel_mm": 0.2, "solids": []}, "tool": "hammer"})");
  refuse(servo("tool.json", "hand.csv"), AllOf(HasSubstr("\"hammer\""), HasSubstr("round_012")));
}

TEST_F(BadInput, AnUnboundedSolidAsksForADomain) {
  folder.write(
      "half.json",
      R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"halfspace": {"normal": [0,0,1], "offset_mm": 0}}}]}, "tool": "round_012"})");
  refuse(servo("half.json", "hand.csv"), HasSubstr("domain_mm"));
}

TEST_F(BadInput, AVolumeTooLargeForMemoryIsRefusedBeforeAnyAllocation) {
  folder.write(
      "big.json",
      R"({"tissue": {"voxel_mm": 0.01, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 500}}}]}, "tool": "round_012"})");
  refuse(servo("big.json", "hand.csv"), HasSubstr("voxels"));
}

TEST_F(BadInput, MissingAndUnwritableFilesAreNamed) {
  refuse(servo("nothing.json", "hand.csv"), AllOf(HasSubstr("nothing.json"), HasSubstr("no such file")));
  refuse(servo("scene.json", "nothing.csv"), AllOf(HasSubstr("nothing.csv"), HasSubstr("No such file")));
  refuse(fmt::format("servo {0}/scene.json --hand {0}/hand.csv --out /nowhere/at/all.csv", folder.path().string()),
         HasSubstr("/nowhere/at/all.csv"));
  folder.write("volume.json", R"({"tissue": {"volume": "gone.vdb"}, "tool": "round_012"})");
  refuse(servo("volume.json", "hand.csv"),
         HasSubstr("volume.json: line 1, \"tissue.volume\": found no file \"gone.vdb\""));
}

TEST_F(BadInput, AHandWithTheTimesOfAClockIsRefused) {
  folder.write("clock.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n3600,0,0,30,1,0,0,0,0\n3601,0,0,29,1,0,0,0,0\n");
  refuse(servo("scene.json", "clock.csv"), HasSubstr("clock.csv: line 2, column t_s: found 3600"));
}

// Otherwise a user with twenty scenes does not know in which to look.
TEST_F(BadInput, WhatASceneNamesAndIsNotThereIsNamedWithItsPlaceInTheScene) {
  const std::string ball =
      R"("tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})";
  const std::string bur = R"("tool": "round_012")";
  const std::vector<std::pair<std::string, std::string>> scenes = {
      {R"("tool")", ball + R"(, "tool": "gone")"},
      {R"("tools[1]")", ball + R"(, "tools": ["round_012", "gone"])"},
      {R"("tool.handpiece")", ball + R"(, "tool": {"shape": "sphere", "diameter_mm": 1, "handpiece": "gone"})"},
      {R"("tool_set")", ball + R"(, "tool_set": "gone", "tool": "round_012")"},
      {R"("spindle")", ball + "," + bur + R"(, "spindle": "gone")"},
      {R"("paint_file")", ball + "," + bur + R"(, "paint_file": "gone.json")"},
      {R"("suction.tip")", ball + "," + bur + R"(, "suction": {"position_mm": [0, 0, 9], "tip": "gone"})"},
      {R"("tissue.solids[0].solid.mesh.file")",
       R"("tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"mesh": {"file": "gone"}}}]}, )" + bur},
      {R"("tissue.mesh.file")", R"("tissue": {"mesh": {"file": "gone", "tissue": "enamel"}}, )" + bur}};
  for (const auto& [place, scene] : scenes) {
    folder.write("lacks.json", "{" + scene + "}");
    refuse(servo("lacks.json", "hand.csv"),
           AllOf(HasSubstr("lacks.json: line 1, " + place + ": found"), HasSubstr("gone")));
  }
}

TEST_F(BadInput, GarbageInPlaceOfAVolumeOrASessionIsAnErrorNotACrash) {
  folder.write("junk.vdb", std::string(5000, '\x5a'));
  folder.write("volume.json", R"({"tissue": {"volume": "junk.vdb"}, "tool": "round_012"})");
  refuse(servo("volume.json", "hand.csv"), HasSubstr("junk.vdb"));
  folder.write("junk.h5", std::string(5000, '\x5a'));
  refuse("replay " + (folder / "junk.h5") + " --check", HasSubstr("junk.h5"));
}

TEST_F(BadInput, ATruncatedScanIsNamedWithFoundAndExpected) {
  folder.write("scan.nhdr",
               "NRRD0001\ntype: unsigned short\ndimension: 3\nsizes: 20 20 20\nspacings: 0.1 0.1 0.1\n"
               "data file: scan.raw\nendian: big\nencoding: raw\n");
  folder.write("scan.raw", std::string(1000, 'a'));
  refuse(fmt::format("import {0}/scan.nhdr --preset tooth --out {0}/out.vdb", folder.path().string()),
         HasSubstr("scan"));
}

TEST_F(BadInput, UsageErrorsExitWithStatusTwo) {
  EXPECT_EQ(folder.run("servo").status, 2);
  EXPECT_EQ(folder.run("fly").status, 2);
  EXPECT_EQ(folder.run("servo --help").status, 0);
  EXPECT_EQ(folder.run("--version").status, 0);
}

}  // namespace
}  // namespace typodont
