// Tests scenes with a mesh and the model "mesh_lod" as users run them: the program, its files, and its exit statuses.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class MeshLodCommand : public ::testing::Test {
 protected:
  /// A box of 8 × 8 × 2 mm, its top at z = 0, as an OBJ file with 162 vertices on the top.
  void write_block() {
    std::string text;
    const auto vertex = [&](double x, double y, double z) {
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
    };
    constexpr int n = 8;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) vertex(i - 4, j - 4, 0), vertex(i - 4, j - 4, -2);
    const auto at = [](int i, int j, int below) { return std::to_string(2 * (i * (n + 1) + j) + below + 1); };
    const auto face = [&](const std::string& a, const std::string& b, const std::string& c, const std::string& d) {
      text += "f " + a + " " + b + " " + c + "\nf " + a + " " + c + " " + d + "\n";
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        face(at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0));
        face(at(i, j, 1), at(i, j + 1, 1), at(i + 1, j + 1, 1), at(i + 1, j, 1));
      }
      face(at(i, 0, 1), at(i + 1, 0, 1), at(i + 1, 0, 0), at(i, 0, 0));
      face(at(i + 1, n, 1), at(i, n, 1), at(i, n, 0), at(i + 1, n, 0));
      face(at(0, i + 1, 1), at(0, i, 1), at(0, i, 0), at(0, i + 1, 0));
      face(at(n, i, 1), at(n, i + 1, 1), at(n, i + 1, 0), at(n, i, 0));
    }
    folder.write("block.obj", text);
  }
  std::string scene(const std::string& more) {
    return folder.write(
        "scene.json",
        R"({"tissue": {"mesh": {"file": "block.obj", "tissue": "dentin", "voxel_mm": 0.2}}, )" + more + "}");
  }
  test::ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(MeshLodCommand, TheLevelFollowsTheSpeedOfTheHandAndIsWrittenToTheTable) {
  write_block();
  // The hand moves along the surface at 10, 60 and 200 mm/s.
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,-3,0,1,1,0,0,0,0\n0.2,-3,0,0.05,1,0,0,0,0\n"
               "0.4,-1,0,0.05,1,0,0,0,0\n0.42,0.2,0,0.05,1,0,0,0,0\n0.52,1.2,0,0.05,1,0,0,0,0\n"
               "0.54,3.2,0,0.05,1,0,0,0,0\n0.8,3.2,0,0.05,1,0,0,0,0\n");
  const std::string s =
      scene(R"("model": {"mesh_lod": {"vertices": 2000, "switch_mm_s": [5, 30]}}, "tool": "explorer")");
  const auto ran = expect_ok(folder.run("servo " + s + " --hand {}/hand.csv --json --out {}/t.csv"));
  const Json json = Json::parse(ran.out, "summary");
  EXPECT_EQ(json["model"].string(), "mesh_lod");
  EXPECT_NEAR(json["elements"].number(), 2000, 20);
  EXPECT_GT(json["force_max_N"].number(), 0.02);
  const std::vector<ServoTick> ticks = session::read_ticks_csv(folder / "t.csv");
  ASSERT_GT(ticks.size(), 700U);
  for (const unsigned level : {0, 1, 2})
    EXPECT_THAT(ticks, ::testing::Contains(::testing::Field(&ServoTick::level, level)));
  EXPECT_EQ(ticks.back().level, 0U);
}

TEST_F(MeshLodCommand, TheLibraryThatSimplifiesIsLoadedByThisModelAndByNoOther) {
  write_block();
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,1,1,0,0,0,0\n0.1,0,0,0.05,1,0,0,0,0\n");
  for (const char* model : {"offset", "voxel_penalty", "packing", "vertex", "mesh_lod"}) {
    const auto ran = folder.run("servo " + scene(R"("tool": "explorer")") + " --hand " + folder / "hand.csv" +
                                    " --model " + model + " --out " + folder / "t.csv",
                                "env LD_DEBUG=libs");  // the dynamic linker names each library on standard error
    ASSERT_EQ(ran.status, 0) << ran.out;
    ASSERT_THAT(ran.err, HasSubstr("libstdc++"));
    EXPECT_EQ(ran.err.find("libmeshoptimizer") != std::string::npos, std::string(model) == "mesh_lod") << model;
  }
}

TEST_F(MeshLodCommand, InTheExploreSceneCariesIsSoftAndHoldsTheTipAndEnamelIsHardAndDoesNot) {
  // The hand moves down on the tooth, to a depth of 1 mm and more, and up again.
  const auto pushes = [&](const std::string& place, double& most, double& least) {
    folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0," + place + ",23,1,0,0,0,0\n0.5," + place +
                                 ",19.5,1,0,0,0,0\n1.5," + place + ",17.5,1,0,0,0,0\n1.9," + place +
                                 ",17.5,1,0,0,0,0\n3," + place + ",20.5,1,0,0,0,0\n");
    expect_ok(folder.run("servo assets/scenes/explore-caries.json --model mesh_lod --hand {}/hand.csv --out {}/t.csv"));
    most = least = 0;
    for (const ServoTick& tick : session::read_ticks_csv(folder / "t.csv")) {
      most = std::max(most, tick.f_T_W.z), least = std::min(least, tick.f_T_W.z);
    }
  };
  double most = 0, least = 0;
  pushes("7.0,6.0", most, least);
  EXPECT_GT(most, 0.2);
  EXPECT_LT(most, 0.5);
  EXPECT_LT(least, -0.15) << "the tip is held when it is drawn out";
  pushes("7.0,4.6", most, least);
  EXPECT_GT(most, 1.2);
  EXPECT_GT(least, -0.01);
}

TEST_F(MeshLodCommand, InTheToothSectionTheTipFindsTheStripOfDentinAndSticksInCaries) {
  // The hand draws the tip from the pulp over the strip of dentin (9.8 to 10 mm) to the enamel and back, and then
  // pushes it into the caries, presses the pedal and pulls it out.
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,8.8,8.7,22,1,0,0,0,0\n0.3,8.8,8.7,19.9,1,0,0,0,0\n"
               "1.3,10.4,8.7,19.9,1,0,0,0,0\n2.3,8.8,8.7,19.9,1,0,0,0,0\n2.5,8.8,8.7,22,1,0,0,0,0\n"
               "2.9,3.4,12.38,22,1,0,0,0,0\n3.5,3.4,12.38,18.7,1,0,0,0,0\n3.7,3.4,12.38,18.7,1,0,0,0,1\n"
               "3.9,3.4,12.38,18.7,1,0,0,0,0\n5.1,3.4,12.38,22,1,0,0,0,0\n");
  expect_ok(folder.run("servo assets/scenes/tooth-section.json --hand {}/hand.csv --out {}/t.csv"));
  const std::vector<ServoTick> ticks = session::read_ticks_csv(folder / "t.csv");
  std::vector<double> caught;  // mm, positions of the tip where a wall yielded
  double back = 0, held = 0;   // N
  for (std::size_t i = 1; i + 1 < ticks.size(); ++i) {
    const double t = to_seconds(ticks[i].t), along = ticks[i].f_T_W.x;
    const bool peak = along < ticks[i - 1].f_T_W.x && along <= ticks[i + 1].f_T_W.x;
    if (t > 0.35 && t < 1.3 && along < -0.06 && peak) caught.push_back(1e3 * ticks[i].X_WG.p.x);
    if (t > 1.35 && t < 2.25) back = std::min(back, along);
    if (t > 3.9) held = std::min(held, ticks[i].f_T_W.z);
  }
  ASSERT_EQ(caught.size(), 2U);
  EXPECT_NEAR(caught[1] - caught[0], 0.2, 0.05);
  EXPECT_GE(back, -1e-3) << "nothing holds the tip on its way back";
  EXPECT_LT(held, -0.15) << "the caries holds the tip when it is pulled out";

  // The same hand on the mirror rig: a picture for each eye, in which both the tissue and the tool are visible.
  expect_ok(folder.run(
      "render assets/scenes/tooth-section.json --rig mirror --magnify 5 --pose {}/hand.csv --at 0.9 --size 480x270 "
      "--out {}/pictures"));
  for (const char* eye : {"left.png", "right.png"}) {
    EXPECT_GT(std::filesystem::file_size(folder / ("pictures/" + std::string(eye))), 2000U) << eye;
  }
}

TEST_F(MeshLodCommand, AMeshIsAlsoTissueForTheOtherModels) {
  write_block();
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0.1,0.1,1.5,1,0,0,0,0\n0.4,0.1,0.1,0.4,1,0,0,0,0\n"
               "1,0.1,0.1,0.4,1,0,0,0,0\n");
  const std::string s = scene(R"("tool": {"shape": "sphere", "diameter_mm": 1.2, "cuts": false})");
  std::vector<double> force;
  for (const char* model : {"offset", "mesh_lod", "voxel_penalty"}) {
    expect_ok(folder.run("servo " + s + " --model " + model + " --hand {}/hand.csv --out {}/t.csv"));
    force.push_back(session::read_ticks_csv(folder / "t.csv").back().f_T_W.z);
  }
  EXPECT_NEAR(force[0], 0.1, 0.01);  // 0.2 mm into dentin of 0.5 N/mm
  EXPECT_NEAR(force[1], force[0], 0.005);
  EXPECT_GT(force[2], 0);
}

TEST_F(MeshLodCommand, BadMeshesAreRefusedWithAReasonAndASelfIntersectingMeshIsAccepted) {
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,1,1,0,0,0,0\n0.1,0,0,1,1,0,0,0,0\n");
  const auto run = [&](const std::string& bytes, const std::string& name) {
    folder.write(name, bytes);
    const std::string scene = folder.write(
        "scene.json", R"({"tissue": {"mesh": {"file": ")" + name +
                          R"(", "tissue": "dentin", "voxel_mm": 0.2}}, "model": "mesh_lod", "tool": "explorer"})");
    return folder.run("servo " + scene + " --hand {}/hand.csv --out {}/t.csv");
  };
  const auto error_of = [&](const std::string& bytes, const std::string& name = "block.obj") {
    const auto ran = run(bytes, name);
    EXPECT_EQ(ran.status, 2) << ran.out;
    return ran.err;
  };
  /// Returns a binary STL with a cube at each of these corners. Its header claims to hold `count` triangles.
  const auto cubes = [](const std::vector<float>& corners, std::uint32_t count) {
    std::string text(80, '\0');
    const auto put = [&](const auto& value) {
      const char* bytes = reinterpret_cast<const char*>(&value);
      text.append(bytes, sizeof value);
    };
    put(count);
    constexpr int kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const float at : corners) {
      for (const auto& side : kSides) {
        for (const int half : {1, 2}) {
          for (int k = 0; k < 3; ++k) put(0.0F);
          for (const int corner : {side[0], side[half], side[half + 1]}) {
            for (int axis = 0; axis < 3; ++axis) put(at + (corner >> axis & 1 ? 5.0F : 0.0F));
          }
          put(std::uint16_t{0});
        }
      }
    }
    return text;
  };
  EXPECT_THAT(error_of(""), AllOf(HasSubstr("block.obj"), HasSubstr("an empty file")));
  EXPECT_THAT(error_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"), HasSubstr("block.obj"));
  EXPECT_THAT(error_of("v 0 0 0\nv 1000 0 0\nv 0 1000 0\nf 1 2 3\n"), HasSubstr("unit_mm"));
  EXPECT_THAT(error_of("v 0 0 0\nv 5 0 0\nv 2 0 0\nf 1 2 3\n"), HasSubstr("1 triangles without area"));
  EXPECT_THAT(error_of(cubes({std::nanf("")}, 12), "a.stl"), AllOf(HasSubstr("vertex 0"), HasSubstr("nan")));
  EXPECT_THAT(error_of(cubes({0}, 100'000'000), "a.stl"), HasSubstr("100000000 in 684 bytes"));
  expect_ok(run(cubes({0, 2}, 24), "a.stl"));  // a mesh that crosses itself is touched from outside
}

TEST_F(MeshLodCommand, FitDampingPrintsTheCouplingOfAScene) {
  std::string curve = "t_s,depth_mm,force_N\n";
  for (int i = 0; i < 400; ++i) {
    const double t = 1e-3 * i, depth = 0.3 + 0.2 * std::sin(20 * t), rate = 4 * std::cos(20 * t);  // mm, mm/s
    curve += std::to_string(t) + "," + std::to_string(depth) + "," + std::to_string(0.7 * depth + 0.01 * rate) + "\n";
  }
  const auto ran = expect_ok(folder.run("fit-damping " + folder.write("curve.csv", curve) + " --json"));
  const Json json = Json::parse(ran.out, "fit");
  EXPECT_NEAR(json["stiffness_N_per_mm"].number(), 0.7, 0.007);
  EXPECT_NEAR(json["damping_Ns_per_mm"].number(), 0.01, 0.0001);
  EXPECT_EQ(folder.run("fit-damping " + folder.write("bad.csv", "t_s,depth_mm,force_N\n0,1\n")).status, 2);
}

}  // namespace
}  // namespace typodont
