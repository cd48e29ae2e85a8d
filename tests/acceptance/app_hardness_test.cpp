// Tests caries with varying hardness as a user works with it: it is painted in layers, drilled, recorded, replayed and
// reported. Also tests limits that a scene sets itself.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "engine/app/recording/recorded_tissue.h"
#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"
#include "engine/base/units.h"
#include "engine/render/picture.h"
#include "engine/session/session_file.h"
#include "haptics/dense_tissue.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using haptics::hardness_byte;
using haptics::hardness_fraction;
using test::ProgramFolder;

constexpr auto kCaries = static_cast<std::size_t>(Tissue::kCaries);

/// A block with a lesion in its top, 1.5 mm deep: in three layers of half a millimetre, the softest above.
std::string scene(const std::string& more = "") {
  return R"({"tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [8, 6, 4]}}}]},
  "paint": [
    {"tissue": "caries", "hardness": 0.9, "solid": {"box": {"center_mm": [0, 0, 1.5], "size_mm": [6, 4, 2]}}},
    {"tissue": "caries", "hardness": 0.6, "color": [0.3, 0.2, 0.1],
     "solid": {"box": {"center_mm": [0, 0, 2.0], "size_mm": [6, 4, 2]}}},
    {"tissue": "caries", "hardness": 0.3, "solid": {"box": {"center_mm": [0, 0, 2.5], "size_mm": [6, 4, 2]}}}],
  "tool": {"shape": "sphere", "diameter_mm": 1.6}, "spindle_krpm": 300, "parts": ["haptics"],
  "coupling": {"stiffness_N_per_mm": 4, "damping_Ns_per_mm": 0.008})" +
         more + "}";
}

/// Two strokes through the lesion's top, `depth` mm deep, with a pause between them and one at the end.
std::string hand(double depth) {
  std::string csv = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  double t = 0;
  const auto row = [&](double x, double z, double pedal, double wait) {
    csv += fmt::format("{:.3f},{},0,{},1,0,0,0,{}\n", t, x, z, pedal);
    t += wait;
  };
  for (const double x : {-1.5, 0.5}) {
    row(x, 4, 0, 0.25), row(x, 3, 1, 0.2), row(x, 2.8 - depth, 1, 2), row(x + 1, 2.8 - depth, 1, 0.5);
    row(x + 1, 4, 0, 0.45);
  }
  row(2, 4, 0, 0.5), row(2, 4, 0, 0);
  return csv;
}

struct GradedCaries : testing::Test {
  ProgramFolder folder{TYPODONT_PROGRAM};
  nlohmann::json json_of(const std::string& arguments) const {
    const test::Ran ran = expect_ok(folder.run(arguments));
    return nlohmann::json::parse(ran.out, nullptr, false);
  }
};

TEST_F(GradedCaries, IsReplayedBitForBitAndTheReportStatesTheHardnessOfTheRemovedTissue) {
  folder.write("scene.json", scene());
  double last = 0;
  for (const double depth : {0.4, 1.4}) {
    folder.write("hand.csv", hand(depth));
    const std::string session = folder / fmt::format("{}.h5", depth);
    folder.run("servo {}/scene.json --hand {}/hand.csv --out " + session);
    EXPECT_TRUE(json_of("replay " + session + " --check --json")["identical"]);
    const double mean =
        json_of("report " + session + " --json --out " + (folder / "r.html"))["removed_hardness"]["caries"];
    EXPECT_GT(mean, last) << "the deeper, the harder";
    last = mean;
    EXPECT_NE(test::read_text(folder / "r.html").find("Hardness of the removed"), std::string::npos);
    if (depth == 0.4) {
      EXPECT_NEAR(mean, 0.3, 0.01) << "in the uppermost layer alone";
    }
    // Compares with the mean hardness that is computed from the volumes.
    const session::SessionReader reader(session);
    const Scene of = scene_of(reader);
    const haptics::TissueVolume start = load_tissue(of), end = tissue_at_end(reader, of, load_tissue(of));
    const double removed = start.volumes()[kCaries] - end.volumes()[kCaries];
    EXPECT_GT(removed, 0.3 * kCubicMillimetre);
    EXPECT_NEAR(mean, (start.hardness_volumes()[kCaries] - end.hardness_volumes()[kCaries]) / removed, 1e-9);
  }
  EXPECT_GT(last, 0.4);
}

TEST_F(GradedCaries, KeepsItsHardnessInSavedVolumesAndInStrokeFiles) {
  const auto mean = [&](const std::string& text) {
    const haptics::TissueVolume volume = load_tissue(parse_scene(Json::parse(text, "scene"), folder / "scene.json"));
    return volume.hardness_volumes()[kCaries] / volume.volumes()[kCaries];
  };
  const double middle = (0.3 + 0.6 + 0.9) / 3;
  EXPECT_NEAR(mean(scene()), middle, 0.01);
  // The uppermost layer is removed before the session begins.
  EXPECT_NEAR(mean(scene(R"(, "prepare": [{"box": {"center_mm": [0, 0, 2.45], "size_mm": [9, 9, 2]}}])")),
              (0.6 + 0.9) / 2, 0.01);
  load_tissue(parse_scene(Json::parse(scene(), "scene"), folder / "scene.json")).save(folder / "kept.vdb");
  EXPECT_NEAR(mean(R"({"tissue": {"volume": "kept.vdb"}, "tool": "round_012"})"), mean(scene()), 1e-12);
  folder.write("strokes.json", R"({"strokes": [
    {"tissue": "caries", "a_mm": [0, 0, 0], "radius_mm": 1, "hardness": 0.25}]})");
  EXPECT_NEAR(mean(R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm":
    [4, 4, 4]}}}]}, "tool": "round_012", "paint_file": "strokes.json"})"),
              hardness_fraction(hardness_byte(0.25)), 1e-12);
}

/// Returns the error message for a scene, or an empty text.
std::string fault_of(const std::string& text) {
  return test::refusal([&] { (void)load_tissue(parse_scene(Json::parse(text, "scene.json"), "scene.json")); });
}

TEST_F(GradedCaries, APreparedDepositLiesOnTheTissueAndLeavesItUnchanged) {
  const auto volumes = [&](const std::string& more) {
    return load_tissue(parse_scene(Json::parse(scene(more), "scene"), folder / "scene.json")).volumes();
  };
  const PerTissue bare = volumes("");
  // Half of the ball is inside the block; the other half rises above the volume's stored distances.
  const PerTissue covered = volumes(
      R"(, "prepare": [{"tissue": "composite", "solid": {"sphere": {"center_mm": [0, 0, 2], "radius_mm": 2.5}}}])");
  const double half_voxel = 1.1 * kCubicMillimetre;  // over the disc of 20 mm² where they meet
  for (const Tissue t : {Tissue::kDentin, Tissue::kCaries})
    EXPECT_NEAR(covered[static_cast<std::size_t>(t)], bare[static_cast<std::size_t>(t)], half_voxel);
  const double half_ball = 2.0 / 3 * kPi * std::pow(2.5e-3, 3);
  EXPECT_NEAR(covered[static_cast<std::size_t>(Tissue::kComposite)], half_ball, half_voxel);
  EXPECT_THAT(fault_of(scene(R"(, "prepare": [{"tissue": "composite", "solid": {"halfspace": {"normal": [0, 0, 1],
      "offset_mm": 0}}}])")),
              testing::HasSubstr("a bounded solid"));
}

TEST_F(GradedCaries, KeepsTheColoursOfItsVoxelsInVolumesStrokesPicturesAndMeshes) {
  const std::string red = R"("color": [0.9, 0.1, 0.1])";
  const std::string block = R"({"tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [8, 6, 4]}}}]}, "tool": "round_012", "parts": ["render"])";
  folder.write("strokes.json", R"({"strokes": [{"tissue": "dentin", "a_mm": [-2, 0, 2], "b_mm": [2, 0, 2],
    "radius_mm": 1, )" + red + "}]}");
  folder.write("stroke.json", block + R"(, "paint_file": "strokes.json"})");
  folder.write("solid.json", block + R"(, "paint": [{"tissue": "dentin", )" + red + R"(, "solid":
    {"capsule": {"a_mm": [-2, 0, 2], "b_mm": [2, 0, 2], "radius_mm": 1}}}]})");
  const haptics::TissueVolume painted = load_tissue(read_scene(folder / "stroke.json"));
  EXPECT_EQ(painted.hash(), load_tissue(read_scene(folder / "solid.json")).hash());
  painted.save(folder / "kept.vdb");
  folder.write("kept.json", R"({"tissue": {"volume": "kept.vdb"}, "tool": "round_012", "parts": ["render"]})");

  // The mesh has the stroke's colour in its middle and the tissue's beside it.
  expect_ok(folder.run("mesh {}/kept.json --out {}/m.obj"));
  std::istringstream lines(test::read_text(folder / "m.obj"));
  int middle = 0, beside = 0;
  for (std::string line; std::getline(lines, line);) {
    dvec3 p, c;
    if (std::sscanf(line.c_str(), "v %lf %lf %lf %lf %lf %lf", &p.x, &p.y, &p.z, &c.x, &c.y, &c.z) != 6) continue;
    const bool is_red = glm::length(c - srgb_of(voxel_color({0.9, 0.1, 0.1}))) < 1e-3;
    const bool in_middle = p.z > 1.99 && std::abs(p.y) < 0.9 && std::abs(p.x)<2, is_beside = std::abs(p.y)> 1.2;
    EXPECT_TRUE(in_middle ? is_red : !(is_beside && is_red)) << line;
    middle += in_middle, beside += is_beside;
  }
  EXPECT_GT(middle, 3);
  EXPECT_GT(beside, 3);

  // So does the picture, seen from above.
  folder.write("rig.json", R"({"display": "offscreen", "screen": {"corners_mm": {"lower_left": [-4,-3,2],
    "lower_right": [4,-3,2], "upper_left": [-4,3,2]}, "pixels": [160, 120], "layout": "mono"},
    "head": {"eye_center_mm": [0, 0, 400], "ipd_mm": 64}})");
  expect_ok(folder.run("render {}/kept.json --rig {}/rig.json --out {}/out"));
  const render::Picture picture = render::read_png(folder / "out/screen.png");
  const auto redness = [&](int y) {  // red divided by green along the middle third of a row
    double r = 0, g = 0;
    for (int x = 60; x < 100; ++x) {
      const std::uint8_t* const pixel = picture.at(x, y);
      r += pixel[0], g += pixel[1];
    }
    return r / g;
  };
  EXPECT_GT(redness(60), 2.0);
  EXPECT_LT(redness(20), 1.4);
}

TEST(SceneKeys, HardnessAndLimitsOutOfRangeAreRefusedWithTheAllowedRange) {
  using testing::AllOf;
  using testing::HasSubstr;
  const std::string block = R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin"HARDNESS, "solid":
    {"box": {"size_mm": [4, 4, 4]}}}]}, "tool": "round_012"MORE})";
  const auto with = [&](const std::string& hardness, const std::string& more) {
    std::string text = block;
    text.replace(text.find("HARDNESS"), 8, hardness);
    text.replace(text.find("MORE"), 4, more);
    return fault_of(text);
  };
  EXPECT_EQ(with("", ""), "");
  EXPECT_EQ(with(R"(, "hardness": 0)", R"(, "force_limit_N": 300, "torque_limit_Nmm": 20000)"), "");
  const Json own = Json::parse(scene(R"(, "torque_limit_Nmm": 4000)"), "scene");
  EXPECT_DOUBLE_EQ(parse_scene(own, "scene.json").servo.torque_limit, 4) << "N·m";
  EXPECT_THAT(with(R"(, "color": [0, 0, 1.5])", ""), AllOf(HasSubstr("color"), HasSubstr("three numbers from 0 to 1")));
  EXPECT_THAT(with(R"(, "hardness": 1.5)", ""), AllOf(HasSubstr("hardness"), HasSubstr("1.5"), HasSubstr("0 to 1")));
  EXPECT_THAT(with("", R"(, "paint": [{"tissue": "caries", "hardness": -1, "solid": {"sphere": {"radius_mm": 1}}}])"),
              AllOf(HasSubstr("paint"), HasSubstr("hardness"), HasSubstr("0 to 1")));
  EXPECT_THAT(with("", R"(, "prepare": [{"sphere": {"radius": 1}}])"),
              AllOf(HasSubstr("prepare[0].sphere.radius"), HasSubstr("(is \"radius_mm\" meant?)")));
  EXPECT_THAT(with("", R"(, "task": {"goal": "g", "ideal": {"volume": "v.vdb", "grow_mm": 1}})"),
              AllOf(HasSubstr("task.ideal.grow_mm"), HasSubstr("grow_mm beside volume")));
  EXPECT_THAT(with("", R"(, "force_limit_N": 301)"),
              AllOf(HasSubstr("force_limit_N"), HasSubstr("301"), HasSubstr("0.1 to 300")));
  EXPECT_THAT(with("", R"(, "torque_limit_Nmm": 0)"), AllOf(HasSubstr("torque_limit_Nmm"), HasSubstr("1 to 20000")));
}

TEST_F(GradedCaries, ASessionWithItsOwnForceLimitIsReplayedWithThatLimit) {
  // A stiff ball, pressed so deep that it would push back with 200 N.
  folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.5, "band_mm": 5, "solids": [
    {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 20}}}]}, "materials": {"enamel": {"stiffness_N_per_mm": 1}},
    "tool": {"shape": "sphere", "diameter_mm": 6, "cuts": false}, "coupling": {"stiffness_N_per_mm": 100,
    "damping_Ns_per_mm": 0}, "friction": false, "force_limit_N": 150})");
  folder.write(
      "hand.csv",
      "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,24,1,0,0,0,0\n0.3,0,0,21,1,0,0,0,0\n0.6,0,0,21,1,0,0,0,0\n");
  const std::string session = folder / "s.h5";
  expect_ok(folder.run("servo {}/scene.json --hand {}/hand.csv --out " + session));
  const ReplayResult replay = replay_session(session::SessionReader(session));
  EXPECT_TRUE(replay.identical) << replay.what_differs;
  const auto last = session::SessionReader(session).ticks().back();
  EXPECT_NEAR(last.f_T_W.z, 150, 1e-9);
  EXPECT_TRUE(last.faults & bits(Fault::kForceLimit));
  // The same hand with another limit.
  const auto with =
      json_of("replay " + session + " --with '{\"force_limit_N\": 300}' --json --out " + (folder / "o.h5"));
  EXPECT_NEAR(session::SessionReader(folder / "o.h5").ticks().back().f_T_W.z, 200, 0.5) << with.dump();
}

}  // namespace
}  // namespace typodont
