// A scan of the user's own, carved with the model vertex: the program, its files, its replay.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

/// A sheet of 12 × 12 mm at z = 0, open on all sides, of faces of 4 mm, as a text STL.
std::string sheet() {
  std::string text = "solid scan\n";
  const auto face = [&](const std::array<int, 6>& xy) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (std::size_t i = 0; i < 6; i += 2) {
      text += "vertex " + std::to_string(4 * xy[i] - 6) + " " + std::to_string(4 * xy[i + 1] - 6) + " 0\n";
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

TEST(VertexCommand, TheShippedOpenArchIsCarvedAndReplayedToTheBit) {
  test::ProgramFolder folder{TYPODONT_PROGRAM};
  // Onto the highest cusp, into it, and along.
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,29.49,-17.39,34.16,1,0,0,0,0\n0.3,29.49,-17.39,32.86,1,0,0,0,0\n"
               "0.4,29.49,-17.39,32.81,1,0,0,0,1\n0.8,29.49,-17.39,32.46,1,0,0,0,1\n1.6,29.89,-17.39,32.36,1,0,0,0,1\n"
               "1.9,29.49,-17.39,35.16,1,0,0,0,0\n");
  const auto ran = folder.run("servo assets/scenes/arch-carve.json --hand " + folder / "hand.csv" + " --json --out " +
                              folder / "s.h5");
  ASSERT_EQ(ran.status, 0) << ran.err;
  const Json told = Json::parse(ran.out, "servo");
  EXPECT_GT(told["elements"].number(), 13'288) << "refined where it was carved";
  EXPECT_GT(told["removed_mm3"]["enamel"].number(0, 10), 0.01);
  EXPECT_GE(told["energy_min_J"].number(-1, 1), -1e-9);
  const auto replayed = folder.run("replay " + folder / "s.h5" + " --check");
  EXPECT_EQ(replayed.status, 0) << replayed.out << replayed.err;
}

TEST(VertexCommand, AnOpenStlIsCarvedRecordedAndReplayedToTheBit) {
  test::ProgramFolder folder{TYPODONT_PROGRAM};
  folder.write("scan.stl", sheet());
  const std::string scene = folder.write(
      "scene.json", R"({"name": "scan", "tissue": {"mesh": {"file": "scan.stl", "unit_mm": 1, "tissue": "dentin"}},
                       "model": {"vertex": {"edge_mm": 0.15}}, "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics"]})");
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0.3,0.2,1.5,1,0,0,0,0\n0.3,0.3,0.2,0.8,1,0,0,0,1\n"
               "0.6,0.3,0.2,0,1,0,0,0,1\n1.2,1.3,0.2,-0.2,1,0,0,0,1\n1.4,1.3,0.2,2,1,0,0,0,0\n");
  const auto ran = folder.run("servo " + scene + " --hand " + folder / "hand.csv" + " --json --out " + folder / "s.h5");
  ASSERT_EQ(ran.status, 0) << ran.err;
  const Json told = Json::parse(ran.out, "servo");
  EXPECT_EQ(told["model"].string(), "vertex");
  EXPECT_GT(told["removed_mm3"]["dentin"].number(0, 10), 0.05);
  EXPECT_GE(told["energy_min_J"].number(-1, 1), -1e-9);
  const auto replayed = folder.run("replay " + folder / "s.h5" + " --check --json");
  EXPECT_EQ(replayed.status, 0) << replayed.err;
  EXPECT_TRUE(Json::parse(replayed.out, "replay")["identical"].boolean());
}

}  // namespace
}  // namespace typodont
