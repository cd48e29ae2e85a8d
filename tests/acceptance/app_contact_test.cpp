// Tests `typodont servo` and `replay` through the command line: the behaviour of a scene's tissue and tools with a
// hand.
#include <gmock/gmock.h>

#include "engine/app/recording.h"
#include "engine/base/units.h"
#include "engine/session/session_file.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr const char* kHeader = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";

class ServoOn : public testing::Test {
 protected:
  ProgramFolder folder{TYPODONT_PROGRAM};

  std::vector<ServoTick> ticks(const std::string& hand = "hand.csv") {
    expect_ok(folder.run("servo {}/scene.json --hand {}/" + hand + " --out {}/t.csv"));
    return session::read_ticks_csv(folder / "t.csv");
  }
  void stroke(const std::vector<std::array<double, 4>>& rows, int pedal) {
    std::string csv = kHeader;
    for (const auto& r : rows) csv += fmt::format("{},{},{},{},1,0,0,0,{}\n", r[0], r[1], r[2], r[3], pedal);
    folder.write("hand.csv", csv);
  }
};

constexpr const char* kCube = R"(ply
format ascii 1.0
element vertex 8
property float x
property float y
property float z
element face 6
property list uchar int vertex_indices
end_header
-2 -2 -2
2 -2 -2
2 2 -2
-2 2 -2
-2 -2 2
2 -2 2
2 2 2
-2 2 2
4 0 3 2 1
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5
4 2 3 7 6
4 3 0 4 7
)";

std::string scene_of(const std::string& solid, const std::string& more) {
  return fmt::format(
      R"({{"tissue": {{"voxel_mm": 0.1, "solids": [{{"tissue": "enamel", "solid": {}}}]}}, "friction": false, {}}})",
      solid, more);
}

TEST_F(ServoOn, AContactModelInASharedObjectReplacesThatOfTheScene) {
  folder.write("scene.json", scene_of(R"({"sphere": {"radius_mm": 1}})", R"("tool": "round_012")"));
  stroke({{0, 0, 0, 4.4}, {1, 0, 0, 4.4}}, 0);
  const std::string servo = "servo {}/scene.json --hand {}/hand.csv --out {}/t.csv";
  expect_ok(folder.run(servo + " --model " TYPODONT_BALL_MODEL));
  const ServoTick tick = session::read_ticks_csv(folder / "t.csv").back();
  // 4 mm and 0.6 mm are the radii of the model's ball and of the tool; the scene's sphere is far away.
  EXPECT_NEAR(tick.depth, 0.2e-3, 1e-6);
  const Ran wrong = folder.run(servo + " --model ./none.so");
  EXPECT_NE(wrong.status, 0);
  EXPECT_THAT(wrong.err, HasSubstr("none.so"));
}

using MeshSolid = ServoOn;

TEST_F(MeshSolid, CombinesWithOtherSolidsAndScales) {
  folder.write("cube.ply", kCube);
  stroke({{0, 0, 0, 3.0}, {0.5, 0, 0, 0.5}}, 0);
  const std::string tool = R"("tool": {"shape": "sphere", "diameter_mm": 1.0, "cuts": false})";
  folder.write("scene.json", scene_of(R"({"difference": [{"mesh": {"file": "cube.ply", "scale": 0.5}},
    {"cylinder": {"radius_mm": 0.7, "height_mm": 9}}]})",
                                      tool));
  EXPECT_LT(glm::length(ticks().back().f_T_W), 1e-3) << "a hole wide enough, through a cube of 2 mm";
  folder.write("scene.json", scene_of(R"({"mesh": {"file": "cube.ply", "scale": 0.5}})", tool));
  EXPECT_NEAR(ticks().back().f_T_W.z, 1.0 + 0.01, 1e-3)
      << "on top of it at z = 1 mm, a millimetre deep, and damped at 5 mm/s";
}

using Pieces = ServoOn;

TEST_F(Pieces, EveryCommandThatRecordsRecordsAllThatLeftTheTissue) {
  // The exercise is a slot through a bar. The end of the bar falls off.
  folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.1, "solids": [
      {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -0.3], "size_mm": [6, 1.6, 0.6]}}},
      {"tissue": "caries", "solid": {"box": {"center_mm": [1.6, 0, -0.3], "size_mm": [1.0, 1.8, 0.8]}}}]},
    "task": {"title": "Slot", "goal": "Cut off the end", "ideal": {"remove_tissue": ["caries"], "grow_mm": 0.1}},
    "tool": {"shape": "sphere", "diameter_mm": 0.9}, "spindle_krpm": 300, "parts": ["haptics", "record"]})");
  for (const auto& [command, file] : std::vector<std::pair<std::string, std::string>>{
           {"servo {}/scene.json --hand expert: --out {}/servo.h5", "servo.h5"},
           {"replay {}/servo.h5 --with '{\"coupling\": {\"stiffness_N_per_mm\": 4}}' --out {}/with.h5", "with.h5"},
           {"demo --scene {}/scene.json --fps 1 --size 160x90 --out {}/demo", "demo/session.h5"},
           {"run {}/scene.json --hand expert: --pedal none --audio none: --record {}/live.h5 --seconds 12",
            "live.h5"}}) {
    expect_ok(folder.run(command));
    const session::SessionReader session(folder / file);
    double left = 0;
    int pieces = 0;
    for (const Cut& cut : session.cuts()) left += total(cut.removed);
    for (const session::SessionEvent& event : session.events())
      if (const auto piece = piece_of(event)) left += total(piece->removed), ++pieces;
    EXPECT_GE(pieces, 1) << file;
    ASSERT_TRUE(session.result()) << file;
    const double before = total(session.header().volumes_before), after = total(session.result()->volumes_after);
    // In a live session, a cut may also count tissue of a piece that fell off, until the servo gets its next snapshot.
    EXPECT_GE(left, before - after - 1e-3 * before) << file;
    if (file != "live.h5") {
      EXPECT_LE(left, before - after + 1e-3 * before) << file;
    }
    const ServoTick last = session.ticks(session.tick_count() - 1, 1).front();
    EXPECT_NEAR(total(last.removed), before - after, 1e-5 * before) << file;
    EXPECT_GT(session.patches().size(), 1u) << file;
    if (file == "servo.h5") expect_ok(folder.run("replay {}/" + file + " --check"));
  }
}

using BoundaryWall = ServoOn;

TEST_F(BoundaryWall, HoldsABurComingFromSofterTissueAndOnlyIfEnabled) {
  // Caries above enamel. A bur that is pressed down through the caries stops at the enamel. Without the wall between
  // the tissues, it continues into the enamel.
  const auto deepest = [&](const char* tool, double half, const char* walls, double voxel) {
    folder.write("scene.json", fmt::format(R"({{"tissue": {{"voxel_mm": {}, "solids": [
        {{"tissue": "caries", "solid": {{"box": {{"center_mm": [0, 0, 0.5], "size_mm": [6, 6, 1]}}}}}},
        {{"tissue": "enamel", "solid": {{"box": {{"center_mm": [0, 0, -1], "size_mm": [6, 6, 2]}}}}}}]}},
      "tool": {}, "spindle_krpm": 100, "boundary_walls": {}}})",
                                           voxel, tool, walls));
    folder.write("path.csv",
                 fmt::format("{}0,0,0,{},1,0,0,0,1\n1.3,0,0,{},1,0,0,0,1\n", kHeader, 1.1 + half, 1.1 + half));
    folder.write(
        "hand.json",
        R"({"path": "path.csv", "mass_kg": 0.15, "damping_Ns_per_m": 5, "stiffness_N_per_m": [2000, 2000, 0], "push_N": [0, 0, -1.5]})");
    const auto all = ticks("hand.json");
    return all.back().X_WG.p.z * 1e3 - half;
  };
  for (const double voxel : {0.1, 0.05}) {
    for (const auto& [tool, half] : {std::pair(R"({"shape": "sphere", "diameter_mm": 1.0})", 0.5),
                                     std::pair(R"({"shape": "cylinder", "diameter_mm": 0.9, "length_mm": 3})", 1.5)}) {
      const double with = deepest(tool, half, "true", voxel), without = deepest(tool, half, "false", voxel);
      EXPECT_GT(with, -0.07) << tool;
      EXPECT_LT(without, 1.4 * with) << tool;
      EXPECT_LT(without, -0.07) << tool;
    }
  }
}

}  // namespace
}  // namespace typodont
