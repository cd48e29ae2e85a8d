// Tests `typodont pack` as users run it: the program, its files, and its exit statuses.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/session/packing_file.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class PackCommand : public ::testing::Test {
 protected:
  std::string scene(const std::string& solid = R"({"sphere": {"radius_mm": 2}})") {
    return folder.write("scene.json", R"({"name": "solid", "tissue": {"voxel_mm": 0.1, "solids": [
        {"tissue": "enamel", "solid": )" + solid +
                                          R"(}]}, "tool": "round_012"})");
  }
  test::ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(PackCommand, TheSummaryAgreesWithTheWrittenPacking) {
  const auto ran =
      expect_ok(folder.run("pack " + scene() + " --spheres 1500 --seed 3 --json --out {}/p.h5 --preview {}/p.png"));
  const Json json = Json::parse(ran.out, "summary");
  const SpherePacking p = session::load_packing(folder / "p.h5");
  EXPECT_EQ(json["spheres"].integer(), 1500);
  EXPECT_EQ(p.size(), 1500u);
  EXPECT_EQ(p.seed, 3u);
  EXPECT_NEAR(json["coverage"].number(), p.coverage(), 1e-12);
  EXPECT_NEAR(json["largest_hole_mm"].number(), p.max_hole * 1e3, 1e-12);
  EXPECT_NEAR(json["tissues"]["enamel"]["volume_mm3"].number(), 4.0 / 3 * 3.14159265 * 8, 0.1);
  EXPECT_THAT(test::read_text(folder / "p.png"), HasSubstr("PNG"));
}

TEST_F(PackCommand, ClosedMeshesArePackedAndOpenOnesRefused) {
  const std::string tetrahedron = "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  folder.write("closed.obj", tetrahedron + "f 1 4 3\n");
  folder.write("open.obj", tetrahedron);
  expect_ok(
      folder.run("pack " + scene(R"({"mesh": {"file": "closed.obj"}})") + " --spheres 200 --out " + folder / "m.h5"));
  EXPECT_EQ(session::load_packing(folder / "m.h5").size(), 200u);
  expect_exit(
      folder.run("pack " + scene(R"({"mesh": {"file": "open.obj"}})") + " --spheres 200 --out " + folder / "o.h5"), 2,
      "open.obj");
  EXPECT_FALSE(std::filesystem::exists(folder / "o.h5"));
}

TEST_F(PackCommand, BadNumbersAndPathsAreRefusedAndLeaveNoFile) {
  const std::string s = scene();
  for (const char* number : {"0", "-5", "1000000000"}) {
    const auto ran = folder.run("pack " + s + " --spheres " + number + " --out {}/x.h5");
    EXPECT_EQ(ran.status, 2) << number;
    EXPECT_THAT(ran.err, AllOf(HasSubstr("--spheres"), HasSubstr(number), HasSubstr("1 to 4000000"))) << number;
  }
  EXPECT_EQ(folder.run("pack " + s + " --spheres 10 --out {}/none/x.h5").status, 2);
  EXPECT_EQ(folder.run("pack {}/none.json --spheres 10 --out {}/x.h5").status, 2);
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_THAT(entry.path().filename().string(), ::testing::Not(HasSubstr("x.h5")));
  }
}

TEST_F(PackCommand, AToolOf200SpheresFromAMeshTouchesAndCutsAndAnOpenMeshIsRefused) {
  // A wedge, its edge down.
  const std::string wedge =
      "v -1 0 -1\nv 1 0 -1\nv -1 -0.7 1\nv 1 -0.7 1\nv -1 0.7 1\nv 1 0.7 1\n"
      "f 1 2 4\nf 1 4 3\nf 1 5 6\nf 1 6 2\nf 3 4 6\nf 3 6 5\nf 2 6 4\n";
  folder.write("wedge.obj", wedge + "f 1 3 5\n");
  folder.write("open.obj", wedge);
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,3.3,1,0,0,0,1\n1,0,0,2.7,1,0,0,0,1\n");
  const auto brand = [&](const std::string& mesh) {
    folder.write("brand.json", R"({"name": "brand", "tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "dentin",
        "solid": {"sphere": {"radius_mm": 2}}}]}, "tool": "round_012", "spindle_krpm": 300,
        "model": {"packing": {"spheres": 1500, "tool_spheres": 200, "tool_mesh": {"file": ")" +
                                   mesh + R"("}}}})");
    return folder.run("servo {}/brand.json --json --hand {}/hand.csv --out {}/t.csv");
  };
  const auto ran = brand("wedge.obj");
  ASSERT_EQ(ran.status, 0) << ran.err;
  const Json json = Json::parse(ran.out, "summary");
  EXPECT_GT(json["force_max_N"].number(), 0.02);
  EXPECT_GT(json["removed_mm3"]["dentin"].number(), 1e-4);
  expect_exit(brand("open.obj"), 2, "open.obj");
}

class FitMaterial : public ::testing::Test {
 protected:
  /// Writes a scene of a block into which a ball of 6 mm is pressed. `more`: further members of the model.
  std::string scene(const std::string& name, const std::string& size, const std::string& more = "") {
    return folder.write(name, R"({"name": "block", "tissue": {"voxel_mm": 0.3, "solids": [
        {"tissue": "cancellous_bone", "solid": {"box": {"size_mm": )" +
                                  size + R"(}}}]},
        "tool": {"shape": "sphere", "diameter_mm": 6}, "spindle_krpm": 1,
        "coupling": {"stiffness_N_per_mm": 60}, "force_limit_N": 200, "model": {"packing": {"spheres": 800)" +
                                  more + "}}}");
  }
  std::string ticks(const std::string& scene, double to_z) {
    folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5.9,1,0,0,0,1\n2,0,0," +
                                 std::to_string(to_z) + ",1,0,0,0,1\n");
    expect_ok(folder.run("servo " + scene + " --no-timing --hand {}/hand.csv --out {}/ticks.csv"));
    return folder / "ticks.csv";
  }
  test::ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(FitMaterial, ARecordedForceCurveGivesDensitiesForTheSceneAndAPlot) {
  const std::string block = scene("scene.json", "[8, 8, 4]");
  // The recorded block is twice as hard as the scene says.
  const std::string hard = scene("hard.json", "[8, 8, 4]", R"(, "density": {"cancellous_bone": 0.1})");
  const auto ran = expect_ok(folder.run("fit-material " + ticks(hard, 4.0) + " --scene " + block +
                                        " --json --out {}/m.json --plot {}/fit.svg"));
  const Json json = Json::parse(ran.out, "summary");
  EXPECT_GT(json["force_max_N"].number(), 1);
  EXPECT_GT(json["fitted_spheres"].integer(), 5);
  const std::vector<Json> error = json["mean_square_error_N2"].items();
  EXPECT_LT(error.back().number(), 0.9);
  EXPECT_LT(error.back().number(), 0.1 * error.front().number());
  double mean = 0;
  const Json material = Json::load(folder / "m.json");
  for (const Json& hardness : material["hardness"].items()) mean += hardness.number();
  EXPECT_NEAR(mean / static_cast<double>(material["hardness"].items().size()), 2, 0.5);
  EXPECT_THAT(test::read_text(folder / "fit.svg"), AllOf(HasSubstr("<svg"), HasSubstr("polyline")));
  EXPECT_EQ(Json::load(folder / "m.json")["sphere"].items().size(),
            static_cast<std::size_t>(json["fitted_spheres"].integer()));
  const std::string with = scene("with.json", "[8, 8, 4]", R"(, "material": "m.json")");
  ticks(with, 5.0);
  // A recording with another tissue, or with another packing, is refused.
  const auto other = folder.run("servo " + scene("other.json", "[8, 8, 5]", R"(, "material": "m.json")") + " --hand " +
                                folder / "hand.csv" + " --out " + folder / "x.csv");
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, AllOf(HasSubstr("m.json"), HasSubstr("tissue_hash")));
  const auto seed = folder.run("servo " + scene("seed.json", "[8, 8, 4]", R"(, "seed": 2, "material": "m.json")") +
                               " --hand " + folder / "hand.csv" + " --out " + folder / "x.csv");
  EXPECT_EQ(seed.status, 2);
  EXPECT_THAT(seed.err, AllOf(HasSubstr("m.json"), HasSubstr("seed")));
  EXPECT_FALSE(std::filesystem::exists(folder / "x.csv"));
}

TEST_F(FitMaterial, ATableOfTheSevenDocumentedColumnsFromOtherCodeGivesTheHardnessOfItsBone) {
  // A machine moves a ball of radius R into bone at 0.1 mm/s; a cap of radius a has the volume rate pi a² v.
  const std::string block = folder.write("machine.json", R"({"name": "machine", "tissue": {"voxel_mm": 0.3, "solids": [
      {"tissue": "cancellous_bone", "solid": {"box": {"size_mm": [9, 9, 5]}}}]},
      "tool": {"shape": "sphere", "diameter_mm": 6, "cutting_coefficient": 0.25}, "spindle_krpm": 1.3,
      "materials": {"cancellous_bone": {"specific_energy_J_per_mm3": 3}}, "model": {"packing": {"spheres": 500}}})");
  constexpr double kR = 3, kFeed = 0.1, kHardness = 1.6;  // mm, mm/s
  const double newtons_per_watt = 1 / (0.25 * kR * 1e-3 * 1300 * 2 * kPi / 60);
  std::string table = "t_s,tool_x_mm,tool_y_mm,tool_z_mm,force_x_N,force_y_N,force_z_N\n";
  for (int i = 0; i <= 2500; ++i) {
    const double t = 0.01 * i, z = 2.5 + kR + 0.1 - kFeed * t, deep = std::max(0.0, 2.5 + kR - z);
    const double rate = kPi * deep * (2 * kR - deep) * kFeed;  // mm³/s
    table += fmt::format("{},0.4,-0.2,{},0,0,{}\n", t, z, kHardness * 3 * rate * newtons_per_watt);
  }
  const auto ran = expect_ok(folder.run("fit-material " + folder.write("machine.csv", table) + " --scene " + block +
                                        " --json --out {}/m.json"));
  const Json material = Json::load(folder / "m.json");
  // Equation 14 changes a sphere by its part of the overlap, so spheres at the rim keep the hardness of the start, 1.
  std::vector<double> hardness;
  for (const Json& each : material["hardness"].items()) hardness.push_back(each.number());
  std::sort(hardness.begin(), hardness.end());
  EXPECT_NEAR(hardness[hardness.size() * 3 / 4], kHardness, 0.15 * kHardness);
  const Json error = Json::parse(ran.out, "summary")["mean_square_error_N2"];
  EXPECT_LT(error.items().back().number(), 0.01 * error.items().front().number());
}

TEST_F(PackCommand, ThePackingOfAnotherSceneIsRefusedByTheServoWithBothHashes) {
  expect_ok(folder.run("pack " + scene() + " --spheres 300 --out {}/p.h5"));
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,9,1,0,0,0,0\n0.01,0,0,9,1,0,0,0,0\n");
  folder.write("other.json", R"({"name": "other", "tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel",
      "solid": {"sphere": {"radius_mm": 1.9}}}]}, "tool": "round_012", "model": {"packing": {"file": "p.h5"}}})");
  const auto ran = folder.run("servo {}/other.json --hand {}/hand.csv --out {}/t.csv");
  EXPECT_EQ(ran.status, 2);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("p.h5"), HasSubstr("tissue_hash"), HasSubstr("the tissue of this scene")));
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv"));
}

TEST_F(PackCommand, WithoutARigTheSceneOfTheHipIsDrawnWithItsOwnRig) {
  const std::string look = " --eye left --size 64x48 --quality bare --out " + folder / "hip";
  const auto ran = expect_ok(folder.run("render acetabular-reaming --json" + look));
  EXPECT_THAT(Json::parse(ran.out, "frame")["rig"].string(), testing::EndsWith("rigs/hip.json"));
  folder.write("bad.json", R"({"tissue": {"voxel_mm": 0.5, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 9}}}]}, "tool": "round_012", "rig": "nowhere"})");
  EXPECT_THAT(folder.run("render {}/bad.json" + look).err, HasSubstr("nowhere: found no such file"));
}

TEST_F(PackCommand, TheViewOfTheSpheresShowsAllSpheresAndIsRefusedForOtherModels) {
  const std::string look = " --view spheres --size 320x240 --out " + folder / "look";
  const auto refused = folder.run("render " + scene() + look);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("offset"), HasSubstr("packing")));
  folder.write("spheres.json", R"({"name": "s", "tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel",
      "solid": {"sphere": {"center_mm": [6.8, 6, 18], "radius_mm": 2}}}]}, "tool": "round_012",
      "model": {"packing": {"spheres": 500}}})");
  expect_ok(folder.run("render {}/spheres.json" + look));
  const Json frame = Json::load(folder / "look/frame.json");
  EXPECT_EQ(frame["spheres"].integer(), 500);
  EXPECT_GT(frame["timing"]["frames_per_second"].number(), 0);
  EXPECT_THAT(test::read_text(folder / "look/left.png"), HasSubstr("PNG"));
}

}  // namespace
}  // namespace typodont
