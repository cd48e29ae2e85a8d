// Tests a user's own scan that is cut with the model "vertex": the program, its files, and the replay.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/player.h"
#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

/// Returns a square sheet of 12 × 12 mm as a text STL. It is open on all sides, and its faces are 4 mm wide. `middle`
/// is in mm.
std::string sheet(const dvec3& middle = dvec3(0)) {
  std::string text = "solid scan\n";
  const auto face = [&](const std::array<int, 6>& xy) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (std::size_t i = 0; i < 6; i += 2) {
      text += fmt::format("vertex {} {} {}\n", middle.x + 4 * xy[i] - 6, middle.y + 4 * xy[i + 1] - 6, middle.z);
    }
    text += "endloop\nendfacet\n";
  };
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      face({x, y, x + 1, y, x + 1, y + 1});
      face({x, y, x + 1, y + 1, x, y + 1});
    }
  }
  return text + "endsolid scan\n";
}

TEST(VertexCommand, TheShippedOpenArchIsCarvedAndReplayedBitForBit) {
  test::ProgramFolder folder{TYPODONT_PROGRAM};
  // The hand moves to the highest cusp, into it, and along it.
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,16.89,6.41,26.66,1,0,0,0,0\n0.3,16.89,6.41,25.36,1,0,0,0,0\n"
               "0.4,16.89,6.41,25.31,1,0,0,0,1\n0.8,16.89,6.41,24.96,1,0,0,0,1\n1.6,17.29,6.41,24.86,1,0,0,0,1\n"
               "1.9,16.89,6.41,27.66,1,0,0,0,0\n");
  const auto ran = expect_ok(folder.run("servo assets/scenes/arch-carve.json --hand {}/hand.csv --json --out {}/s.h5"));
  const Json told = Json::parse(ran.out, "servo");
  EXPECT_GT(told["elements"].number(), 13'288) << "refined where it was carved";
  EXPECT_GT(told["removed_mm3"]["enamel"].number(0, 10), 0.01);
  EXPECT_GE(told["energy_min_J"].number(-1, 1), -1e-9);
  expect_ok(folder.run("replay {}/s.h5 --check"));
}

struct CarvedScan : testing::Test {
  test::ProgramFolder folder{TYPODONT_PROGRAM};
  std::string scene, hand;
  void SetUp() override {
    folder.write("scan.stl", sheet({6.5, 5.8, 20}));  // where the rig looks
    scene = folder.write("scene.json",
                         R"({"name": "scan", "tissue": {"mesh": {"file": "scan.stl", "unit_mm": 1, "tissue": "dentin"}},
            "model": {"vertex": {"edge_mm": 0.15}}, "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics", "render"]})");
    // The hand makes two strokes: down, across and up; then once more beside the first stroke.
    std::string rows = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    for (const auto& [t, x, y, z, pedal] : {std::array{0.0, 6.8, 6.0, 21.5, 0.0},
                                            {0.2, 6.8, 6.0, 20.8, 1.0},
                                            {0.4, 6.8, 6.0, 20.1, 1.0},
                                            {0.7, 7.5, 6.0, 20.1, 1.0},
                                            {0.8, 7.5, 6.0, 22.0, 1.0},
                                            {1.3, 6.8, 7.4, 22.0, 1.0},
                                            {1.4, 6.8, 7.4, 20.1, 1.0},
                                            {1.7, 7.5, 7.4, 20.1, 1.0},
                                            {1.8, 7.5, 7.4, 22.0, 0.0}})
      rows += fmt::format("{},{},{},{},1,0,0,0,{}\n", t, x, y, z, pedal);
    hand = folder.write("hand.csv", rows);
    expect_ok(folder.run("servo " + scene + " --hand " + hand + " --out {}/s.h5 --save {}/left.vdb"));
  }
};

/// What a picture has been given so far.
using Shown = std::map<std::uint64_t, render::MeshUpdate>;
void show(Shown& shown, std::vector<render::MeshUpdate> bricks) {
  for (render::MeshUpdate& brick : bricks) {
    if (brick.indices.empty()) {
      shown.erase(brick.brick);
    } else {
      shown[brick.brick] = std::move(brick);
    }
  }
}
bool same(const Shown& a, const Shown& b) {
  if (a.size() != b.size()) return false;
  for (const auto& [key, brick] : a) {
    const auto found = b.find(key);
    if (found == b.end() || found->second.indices != brick.indices ||
        found->second.vertices.size() != brick.vertices.size())
      return false;
    for (std::size_t i = 0; i < brick.vertices.size(); ++i)
      if (found->second.vertices[i].p != brick.vertices[i].p || found->second.vertices[i].n != brick.vertices[i].n)
        return false;
  }
  return true;
}

TEST_F(CarvedScan, PlayingForwardAndBackwardShowsTheMeshOfEachMoment) {
  SessionPlayer player(folder.path() / "s.h5");
  std::map<double, Shown> first;  // by the moment, each from a player of its own
  for (const double t : {0.1, 0.5, 1.0, 1.75}) {
    SessionPlayer fresh(folder.path() / "s.h5");
    fresh.seek(t);
    show(first[t], fresh.take_surface());
  }
  EXPECT_EQ(first[0.1].begin()->second.two_sided, true) << "the sheet is open";
  EXPECT_FALSE(same(first[0.1], first[0.5]));
  EXPECT_FALSE(same(first[0.5], first[1.0]));
  EXPECT_FALSE(same(first[1.0], first[1.75]));
  Shown shown;
  for (const double t : {0.1, 0.5, 1.0, 1.75, 1.0, 0.5, 0.1, 1.75, 0.1}) {
    player.seek(t);
    show(shown, player.take_surface());
    EXPECT_TRUE(same(shown, first[t])) << t;
  }
}

TEST_F(CarvedScan, IsRenderedAtAGivenTimeAndSavedAsItsMesh) {
  const auto triangles_at = [&](const std::string& options, const std::string& out) {
    const auto ran = expect_ok(folder.run(
        "render {}/s.h5 --rig closeup --size 160x120 --quality bare --json --out {}/" + out + " " + options));
    return Json::parse(ran.out, "render")["frame"]["triangles"].number();
  };
  const double before = triangles_at("--at 0.1", "before"), after = triangles_at("--at 1.8", "after");
  EXPECT_GE(before, 1);
  EXPECT_LE(before, 18) << "the file has no more";
  EXPECT_GT(after, 400);
  EXPECT_GT(triangles_at("--at 1.8 --view section --plane 0,1,0,6", "section"), 100);
  EXPECT_GT(triangles_at("--at 1.8 --view xray", "xray"), 100);
  // An STL has 84 bytes and 50 a triangle.
  const auto bytes = std::filesystem::file_size(folder / "left_surface.stl");
  EXPECT_EQ((bytes - 84) % 50, 0u);
  EXPECT_GE(static_cast<double>((bytes - 84) / 50), after) << "what the picture cuts off is there";
}

TEST(TissueView, ShowsTheSameSurfaceFromACarverAndFromAVolume) {
  const Scene scene = parse_scene(Json::parse(R"({"name": "block", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [4, 4, 4]}}}]}, "tool": "round_012"})",
                                              "b"),
                                  "b");
  haptics::TissueVolume volume = load_tissue(scene);
  haptics::Carver carver(load_tissue(scene), scene.servo);
  ASSERT_EQ(carver.surface(), nullptr);
  Shown one, other;
  show(one, TissueView().update(volume));
  show(other, TissueView().update(carver));
  EXPECT_TRUE(same(one, other));
  EXPECT_FALSE(one.begin()->second.two_sided);
}

}  // namespace
}  // namespace typodont
