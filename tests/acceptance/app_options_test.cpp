// Tests options through the command line. Impossible options are refused with a short sentence. Options that would have
// no effect are refused, too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kScene = R"({"tissue": {"voxel_mm": 0.2, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": {"shape": "sphere", "diameter_mm": 1.0}})";
constexpr const char* kColumns = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";

class Options : public testing::Test {
 protected:
  Options() {
    folder.write("scene.json", kScene);
    folder.write("hand.csv", std::string(kColumns) + "0,0,0,5,1,0,0,0,0\n0.02,0,0,5,1,0,0,0,0\n");
  }
  Ran run(std::string arguments) const {
    for (std::size_t at; (at = arguments.find("{}")) != std::string::npos;)
      arguments.replace(at, 2, folder.path().string());
    return folder.run(arguments, "timeout 60");
  }
  void refuse(const std::string& arguments, const testing::Matcher<std::string>& message) const {
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.status, 2) << arguments << "\n" << ran.err;
    EXPECT_THAT(ran.err, message) << arguments;
    EXPECT_LT(ran.err.size(), 600u) << arguments;
  }
  ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(Options, NumbersMustBeFiniteAndInRange) {
  const std::vector<std::pair<std::string, std::string>> options = {
      {"servo {}/scene.json --hand {}/hand.csv --out {}/x.csv", "--rate"},
      {"servo {}/scene.json --hand {}/hand.csv --out {}/x.csv", "--stall-carver-ms"},
      {"run {}/scene.json", "--rate"},
      {"run {}/scene.json", "--seconds"},
      {"demo --out {}/demo", "--fps"},
      {"demo --out {}/demo", "--seconds"},
      {"replay {}/s.h5 --show", "--speed"},
      {"replay {}/s.h5 --show", "--from"},
      {"replay {}/s.h5 --show", "--to"},
      {"replay {}/s.h5 --film {}/x.mp4", "--fps"},
      {"mesh {}/scene.json --out {}/x.ply", "--tolerance-mm"},
      {"import {}/s.nrrd --out {}/x.vdb", "--voxel-mm"},
      {"import {}/s.nrrd --out {}/x.vdb", "--band-mm"},
      {"import {}/s.stl --out {}/x.vdb", "--unit-mm"},
      {"render {}/scene.json --out {}/x", "--at"},
      {"sound synth m.json --out {}/x.wav", "--seconds"},
      {"sound fit a.wav --out {}/x.json", "--from"},
      {"calibrate register --pairs p.csv", "--sigma-mm"},
      {"calibrate --simulate", "--noise-mm"}};
  for (const auto& [command, option] : options) {
    for (const char* value : {"nan", "-inf", ""})
      refuse(fmt::format("{} {}='{}'", command, option, value), HasSubstr(option));
  }
  refuse("run {}/scene.json --seconds -3", HasSubstr("--seconds: found -3, expected more than 0, at most 86400"));
  refuse("run {}/scene.json --seconds 86401", HasSubstr("at most 86400"));
  refuse("run {}/scene.json --monitor -1", HasSubstr("--monitor: found -1, expected a whole number from 0 on"));
  refuse("servo {}/scene.json --hand {}/hand.csv --out {}/x.csv --rate 1", HasSubstr("expected 10 to 100000"));
}

TEST_F(Options, AnOptionWithoutEffectIsRefused) {
  for (const auto& [command, option] : std::vector<std::pair<std::string, std::string>>{
           {"render {}/scene.json --out {}/x --plane 0,0,1,0", "--plane"},
           {"render {}/scene.json --out {}/x --view xray --plane 0,0,1,0", "--plane"},
           {"render {}/scene.json --out {}/x --ideal i.vdb", "--ideal"},
           {"replay {}/s.h5 --speed 2", "--speed"},
           {"replay {}/s.h5 --check --view xray", "--view"},
           {"replay {}/s.h5 --show --fps 25", "--fps"},
           {"replay {}/s.h5 --film {}/x.mp4 --monitor 0", "--monitor"},
           {"replay {}/s.h5 --beside {}/t.h5", "--beside"},
           {"report {} --out {}/x.html --expert e.h5", "--expert"},
           {"import {}/s.stl --out {}/x.vdb --spacing-mm 0.1", "--spacing-mm"},
           {"import {}/s.stl --out {}/x.vdb --thresholds 1", "--thresholds"},
           {"import {}/s.nrrd --out {}/x.vdb --unit-mm 10", "--unit-mm"},
           {"import {}/s.nrrd --out {}/x.vdb --shell-mm 1", "--shell-mm"},
           {"calibrate --noise-mm 1", "--noise-mm"}})
    refuse(command, AllOf(HasSubstr(option + ": found "), Not(HasSubstr(": : "))));
  EXPECT_FALSE(std::filesystem::exists(folder / "x"));
}

TEST_F(Options, AnOptionForAFolderRefusesTheNameOfAFile) {
  folder.write("taken", "text");
  refuse("render {}/scene.json --out {}/tooth.png",
         HasSubstr("--out: found \"tooth.png\", expected the name of a folder"));
  refuse("render {}/scene.json --out {}/taken", HasSubstr("found the file \"taken\", expected the name of a folder"));
  refuse("demo --out {}/demo.mp4", HasSubstr("found \"demo.mp4\", expected the name of a folder"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "tooth.png"));
}

TEST_F(Options, MessagesBeginWithTheNameOfTheOption) {
  refuse("render {}/scene.json --out {}/x --size 3x", HasSubstr("error: --size: found \"3x\""));
}

TEST_F(Options, ARigIsGivenByNameOrByFile) {
  for (const char* command : {"run {}/scene.json --hand script:{}/hand.csv --rig nothing",
                              "render {}/scene.json --out {}/x --rig nothing", "demo --out {}/demo --rig nothing"})
    refuse(command, AllOf(HasSubstr("nothing: found no such file"), HasSubstr("a rig file, or one of closeup, ")));
  folder.write("scene_with_rig.json", R"({"tissue": {"solids": [{"tissue": "enamel", "solid": {"sphere": {}}}]},
                                          "tool": "round_012", "rig": "nothing"})");
  refuse("render {}/scene_with_rig.json --out {}/x",
         HasSubstr("scene_with_rig.json: \"rig\": nothing: found no such file"));
  const Ran ran = run("run {}/scene.json --hand script:{}/hand.csv --audio none: --rig closeup --json");
  EXPECT_EQ(ran.status, 0) << ran.err;
}

TEST_F(Options, AHandFileIsAtMostADayLongAndBeginsAtZeroOrLater) {
  for (const char* t : {"1e9", "86401"}) {
    folder.write("far.csv", fmt::format("{}0,0,0,5,1,0,0,0,0\n{},0,0,5,1,0,0,0,0\n", kColumns, t));
    refuse("servo {}/scene.json --hand {}/far.csv --out {}/x.csv",
           AllOf(HasSubstr("line 3, column t_s"), HasSubstr("0 to 86400 s, the longest session")));
  }
  folder.write("far.csv", fmt::format("{}-1,0,0,5,1,0,0,0,0\n1,0,0,5,1,0,0,0,0\n", kColumns));
  refuse("servo {}/scene.json --hand {}/far.csv --out {}/x.csv", HasSubstr("line 2, column t_s: found -1"));
  EXPECT_FALSE(std::filesystem::exists(folder / "x.csv"));
}

TEST_F(Options, TheServoCommandStatesItsOutputSizeAndRefusesMoreThanTheFreeDiskSpace) {
  folder.write("day.csv", std::string(kColumns) + "0,0,0,5,1,0,0,0,0\n86400,0,0,5,1,0,0,0,0\n");
  refuse("servo {}/scene.json --hand {}/day.csv --out /dev/shm/typodont_no_room.csv --rate 100000",
         AllOf(HasSubstr("of room"), HasSubstr("for 86400 s at 100000 Hz")));
}

TEST_F(Options, ARunTakesTheMouseByItsNameAndTheExpertAsHand) {
  refuse("run {}/scene.json --hand mouse --audio none: --rig closeup", HasSubstr("a window rig"));
  refuse("run {}/scene.json --hand expert: --audio none: --rig closeup", HasSubstr("ideal"));
}

TEST_F(Options, HelpSaysThatTheProgramWithoutArgumentsOpensTheWindow) {
  EXPECT_THAT(run("--help").out, HasSubstr("Without arguments, typodont opens the operator's window."));
}

TEST_F(Options, ADamagedDicomFileAndAFolderWithoutScansAreRefused) {
  folder.write("slice.dcm", std::string(128, '\0') + "DICM" + std::string(400, '\0'));
  refuse("import {}/slice.dcm --out {}/x.vdb", HasSubstr("found a damaged DICOM file"));
  std::filesystem::create_directory(folder.path() / "empty");
  refuse("import {}/empty --out {}/x.vdb", HasSubstr("found no DICOM images"));
}

TEST_F(Options, PicturesHaveTheRequestedSizeAtEveryQuality) {
  for (const char* quality : {"high", "fast"}) {
    const Ran ran = run(fmt::format("render {{}}/scene.json --out {{}}/x --size 320x200 --quality {}", quality));
    ASSERT_EQ(ran.status, 0) << ran.err;
    for (const char* eye : {"left.png", "right.png"}) {
      const std::string png = read_text(folder.path() / "x" / eye);
      const auto number = [&](std::size_t at) {
        return (static_cast<unsigned char>(png.at(at + 2)) << 8) + static_cast<unsigned char>(png.at(at + 3));
      };
      EXPECT_EQ(number(16), 320) << quality << " " << eye;
      EXPECT_EQ(number(20), 200) << quality << " " << eye;
    }
  }
}

TEST_F(Options, MagnificationWarnsThatPictureAndHandNoLongerCoincide) {
  const Ran ran = run("render {}/scene.json --rig closeup --size 64x48 --out {}/p --magnify 4");
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.err, AllOf(HasSubstr("4 times life-size"), HasSubstr("coincide"), HasSubstr("15 mm from the hand")));
  EXPECT_THAT(run("render {}/scene.json --rig closeup --size 64x48 --out {}/p").err, Not(HasSubstr("life-size")));
  refuse("run {}/scene.json --hand script:{}/hand.csv --rig closeup --magnify 4",
         AllOf(HasSubstr("--magnify"), HasSubstr("a rig with a live picture")));
  refuse("replay {}/s.h5 --magnify 4", HasSubstr("--show or --film"));
}

TEST_F(Options, AShippedSceneIsOpenedByItsName) {
  const Ran ran = run("render tooth-section --rig closeup --quality bare --size 64x48 --out {}/p");
  EXPECT_EQ(ran.status, 0) << ran.err;
  refuse("render no-such-scene --size 64x48 --out {}/p",
         AllOf(HasSubstr("no such file"), HasSubstr("a scene file, or one of acetabular-reaming, ")));
}

TEST_F(Options, AScanOrAVolumeInPlaceOfASceneNamesWhatToDo) {
  folder.write("scan.nrrd", "NRRD0004\n");
  folder.write("IMG0001", std::string(128, '\0') + "DICM");
  folder.write("tooth.vdb", "");
  folder.write("s.h5", "");
  for (const char* scan : {"scan.nrrd", "IMG0001", ""}) {
    refuse(fmt::format("run {{}}/{} --seconds 1", scan), HasSubstr("`typodont import` makes a tissue volume"));
  }
  refuse("run {}/tooth.vdb --seconds 1", HasSubstr("a scene (JSON) that names the volume in \"tissue\""));
  refuse("servo {}/s.h5 --hand {}/hand.csv --out {}/x.csv", HasSubstr("`typodont replay` shows a session"));
}

}  // namespace
}  // namespace typodont
