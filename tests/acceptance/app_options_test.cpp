// Tests options and bad input through the command line. Both are refused with status 2 and a short sentence that names
// place, found and expected, and no file remains.
#include <gmock/gmock.h>

#include <array>
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
  Ran run(const std::string& arguments) const { return folder.run(arguments, "timeout 60"); }
  void refuse(const std::string& arguments, const testing::Matcher<std::string>& message,
              std::size_t longest = 600) const {
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.status, 2) << arguments << "\n" << ran.err;
    EXPECT_THAT(ran.err, message) << arguments;
    EXPECT_LT(ran.err.size(), longest) << arguments;
    EXPECT_EQ(ran.out, "") << arguments;
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
  for (std::size_t i = 0; i < options.size(); ++i) {
    const char* const value = std::array{"nan", "-inf", ""}[i % 3];
    refuse(fmt::format("{} {}='{}'", options[i].first, options[i].second, value), HasSubstr(options[i].second));
  }
  refuse("run {}/scene.json --seconds -3", HasSubstr("--seconds: found -3, expected more than 0, at most 86400"));
  refuse("render {}/scene.json --out {}/x --size 3x", HasSubstr("error: --size: found \"3x\""));
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
           {"import {}/s.stl --out {}/x.vdb --series 1", "--series"},
           {"import {}/s.stl --out {}/x.vdb --hounsfield 0", "--hounsfield"},
           {"import {}/s.stl --out {}/x.vdb --nan-as 0", "--nan-as"},
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

TEST_F(Options, ARigIsGivenByNameOrByFile) {
  for (const char* command : {"run {}/scene.json --hand script:{}/hand.csv --rig nothing",
                              "render {}/scene.json --out {}/x --rig nothing", "demo --out {}/demo --rig nothing"})
    refuse(command, AllOf(HasSubstr("nothing: found no such file"), HasSubstr("a rig file, or one of closeup, ")));
  folder.write("scene_with_rig.json", R"({"tissue": {"voxel_mm": 0.5, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 9}}}]},
                                          "tool": "round_012", "rig": "nothing"})");
  refuse("render {}/scene_with_rig.json --out {}/x",
         HasSubstr("scene_with_rig.json: \"rig\": nothing: found no such file"));
  expect_ok(run("run {}/scene.json --hand script:{}/hand.csv --audio none: --rig closeup --json"));
}

TEST_F(Options, BadInputIsNamedWithFilePlaceFoundAndExpectedAndLeavesNoFile) {
  using Parts = std::vector<testing::Matcher<std::string>>;  // of the message
  const auto command = [&](const std::string& arguments, const Parts& message) {
    refuse(arguments, testing::AllOfArray(message), 1000);  // some messages list all keys or tools
    for (const char* out : {"out.csv", "out.vdb", "out.ply"})
      EXPECT_FALSE(std::filesystem::exists(folder / out)) << arguments;
  };
  const auto hand = [&](const std::string& file, const std::string& rows, const Parts& message) {
    folder.write(file, kColumns + rows);
    command("servo {}/scene.json --hand {}/" + file + " --out {}/out.csv", message);
  };
  const auto scene = [&](const std::string& json, const Parts& message) {
    folder.write("x.json", "{" + json + "}");
    command("servo {}/x.json --hand {}/hand.csv --out {}/out.csv", message);
  };
  const auto solid = [](const char* voxel, const char* json) {
    return fmt::format(R"("tissue": {{"voxel_mm": {}, "solids": [{{"tissue": "enamel", "solid": {}}}]}})", voxel, json);
  };
  const std::string first = "0,0,0,5,1,0,0,0,0\n";
  hand("nan.csv", first + "0.1,0,nan,5,1,0,0,0,0\n",
       {HasSubstr("nan.csv: line 3, column y_mm"), HasSubstr("found \"nan\""), HasSubstr("expected a finite number")});
  hand("back.csv", first + "-1,0,0,5,1,0,0,0,0\n",
       {HasSubstr("line 3, column t_s"), HasSubstr("found -1"), HasSubstr("more than 0")});
  hand("clock.csv", "3600,0,0,30,1,0,0,0,0\n3601,0,0,29,1,0,0,0,0\n",
       {HasSubstr("clock.csv: line 2, column t_s: found 3600")});
  hand("far.csv", first + "86401,0,0,5,1,0,0,0,0\n",
       {HasSubstr("line 3, column t_s"), HasSubstr("0 to 86400 s, the longest session")});
  hand("minus.csv", "-1,0,0,5,1,0,0,0,0\n1,0,0,5,1,0,0,0,0\n", {HasSubstr("line 2, column t_s: found -1")});
  const std::string ball = solid("0.2",
                                 "\n"
                                 R"({"sphere": {"radius_mm": 3}})"),
                    bur = R"(, "tool": "round_012")";
  scene(ball + R"(, "colour": 3)" + bur,
        {HasSubstr("x.json: line 2, \"colour\""), HasSubstr("unknown key"), HasSubstr("tissue")});
  scene(ball + R"(, "case": {"family": "crown", "seed": 1, "dificulty": 0.5})" + bur,
        {HasSubstr("\"case.dificulty\""), HasSubstr("(is \"difficulty\" meant?)")});
  scene(ball + R"(, "model": {"packing": {"density": {"enamal": 1}}})" + bur,
        {HasSubstr("density.enamal\""), HasSubstr("(is \"enamel\" meant?)")});
  scene(ball + R"(, "tool": "hammer")", {HasSubstr("\"hammer\""), HasSubstr("round_012")});
  scene(solid("0.2", R"({"halfspace": {"normal": [0,0,1], "offset_mm": 0}})") + bur, {HasSubstr("domain_mm")});
  scene(solid("0.01", R"({"sphere": {"radius_mm": 500}})") + bur, {HasSubstr("voxels")});  // before any is allocated
  scene(R"("tissue": {"volume": "gone.vdb"})" + bur,
        {HasSubstr("x.json: line 1, \"tissue.volume\": found no file \"gone.vdb\"")});
  command("servo {}/nothing.json --hand {}/hand.csv --out {}/out.csv",
          {HasSubstr("nothing.json"), HasSubstr("no such file")});
  command("servo {}/scene.json --hand {}/nothing.csv --out {}/out.csv",
          {HasSubstr("nothing.csv"), HasSubstr("No such file")});
  command("servo {}/scene.json --hand {}/hand.csv --out /nowhere/at/all.csv", {HasSubstr("/nowhere/at/all.csv")});
  folder.write("scan.vdb", std::string(5000, '\x5a'));
  command("mesh {}/scan.vdb --out {}/out.ply", {HasSubstr("scan.vdb")});
  folder.write("junk.h5", std::string(5000, '\x5a'));
  command("replay {}/junk.h5 --check", {HasSubstr("junk.h5")});
  folder.write("scan.nrrd",
               "NRRD0001\ntype: ushort\ndimension: 3\nsizes: 20 20 20\nspacings: 0.1 0.1 0.1\nendian: "
               "big\nencoding: raw\n\n" +
                   std::string(1000, 'a'));
  command("import {}/scan.nrrd --preset tooth --out {}/out.vdb", {HasSubstr("scan.nrrd")});
  folder.write("slice.dcm", std::string(128, '\0') + "DICM" + std::string(400, '\0'));
  command("import {}/slice.dcm --out {}/out.vdb", {HasSubstr("found a damaged DICOM file")});
  command("servo", {HasSubstr("scene is required")});
  command("fly", {HasSubstr("fly")});
}

TEST_F(Options, WhatASceneNamesAndIsNotThereIsNamedWithItsPlaceInTheScene) {
  const std::string ball =
      R"("tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})";
  const std::string bur = R"("tool": "round_012")";
  const std::vector<std::pair<std::string, std::string>> scenes = {
      {R"("tool")", ball + R"(, "tool": "gone")"},
      {R"("tools[1]")", ball + R"(, "tools": ["round_012", "gone"])"},
      {R"("task.steps[1].tool")",
       ball + "," + bur + R"(, "task": {"goal": "g", "steps": ["a", {"en": "b", "tool": "gone"}]})"},
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
    refuse("servo {}/lacks.json --hand {}/hand.csv --out {}/out.csv",
           AllOf(HasSubstr("lacks.json: line 1, " + place + ": found"), HasSubstr("gone")), 1000);
  }
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

TEST_F(Options, AFolderWithoutScansIsRefused) {
  std::filesystem::create_directory(folder.path() / "empty");
  refuse("import {}/empty --out {}/x.vdb", HasSubstr("found no DICOM images"));
}

TEST_F(Options, PicturesHaveTheRequestedSizeAtEveryQuality) {
  for (const char* quality : {"high", "fast"}) {
    expect_ok(run(fmt::format("render {{}}/scene.json --out {{}}/x --size 320x200 --quality {}", quality)));
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
  const Ran ran = expect_ok(run("render {}/scene.json --rig closeup --size 64x48 --out {}/p --magnify 4"));
  EXPECT_THAT(ran.err, AllOf(HasSubstr("4 times life-size"), HasSubstr("coincide"), HasSubstr("15 mm from the hand")));
  EXPECT_THAT(run("render {}/scene.json --rig closeup --size 64x48 --out {}/p").err, Not(HasSubstr("life-size")));
  refuse("run {}/scene.json --hand script:{}/hand.csv --rig closeup --magnify 4",
         AllOf(HasSubstr("--magnify"), HasSubstr("a rig with a live picture")));
  refuse("replay {}/s.h5 --magnify 4", HasSubstr("--show or --film"));
}

TEST_F(Options, AShippedSceneIsOpenedByItsName) {
  expect_ok(run("render tooth-section --rig closeup --quality bare --size 64x48 --out {}/p"));
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
