// typodont pack as a user meets it: the program, its files, its exit statuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "engine/base/json.h"
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

TEST_F(PackCommand, WritesThePackingThatItsSummaryDescribes) {
  const auto ran = folder.run("pack " + scene() + " --spheres 1500 --seed 3 --json --out " + folder / "p.h5" +
                              " --preview " + folder / "p.png");
  ASSERT_EQ(ran.status, 0) << ran.err;
  const Json json = Json::parse(ran.out, "summary");
  const SpherePacking p = session::load_packing(folder / "p.h5");
  EXPECT_EQ(json["spheres"].integer(), 1500);
  EXPECT_EQ(p.size(), 1500u);
  EXPECT_EQ(p.seed, 3u);
  EXPECT_NEAR(json["coverage"].number(), p.coverage(), 1e-12);
  EXPECT_NEAR(json["largest_hole_mm"].number(), p.largest_hole * 1e3, 1e-12);
  EXPECT_NEAR(json["tissues"]["enamel"]["volume_mm3"].number(), 4.0 / 3 * 3.14159265 * 8, 0.1);
  EXPECT_THAT(test::read_text(folder / "p.png"), HasSubstr("PNG"));
}

TEST_F(PackCommand, TheSameCommandWritesTheSameBytes) {
  const std::string command = "pack " + scene() + " --spheres 800 --out ";
  ASSERT_EQ(folder.run(command + folder / "a.h5").status, 0);
  ASSERT_EQ(folder.run(command + folder / "b.h5").status, 0);
  EXPECT_EQ(test::read_text(folder / "a.h5"), test::read_text(folder / "b.h5"));
}

TEST_F(PackCommand, ClosedMeshesArePackedAndOpenOnesRefused) {
  const std::string tetrahedron = "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  folder.write("closed.obj", tetrahedron + "f 1 4 3\n");
  folder.write("open.obj", tetrahedron);
  const auto closed =
      folder.run("pack " + scene(R"({"mesh": {"file": "closed.obj"}})") + " --spheres 200 --out " + folder / "m.h5");
  EXPECT_EQ(closed.status, 0) << closed.err;
  EXPECT_EQ(session::load_packing(folder / "m.h5").size(), 200u);
  const auto open =
      folder.run("pack " + scene(R"({"mesh": {"file": "open.obj"}})") + " --spheres 200 --out " + folder / "o.h5");
  EXPECT_EQ(open.status, 2);
  EXPECT_THAT(open.err, HasSubstr("open.obj"));
  EXPECT_FALSE(std::filesystem::exists(folder / "o.h5"));
}

TEST_F(PackCommand, BadNumbersAndPlacesAreRefusedAndLeaveNothing) {
  const std::string s = scene();
  for (const char* number : {"0", "-5", "1000000000"}) {
    const auto ran = folder.run("pack " + s + " --spheres " + number + " --out " + folder / "x.h5");
    EXPECT_EQ(ran.status, 2) << number;
    EXPECT_THAT(ran.err, AllOf(HasSubstr("--spheres"), HasSubstr(number), HasSubstr("1 to 4000000"))) << number;
  }
  EXPECT_EQ(folder.run("pack " + s + " --spheres 10 --out " + folder / "none/x.h5").status, 2);
  EXPECT_EQ(folder.run("pack " + folder / "none.json" + " --spheres 10 --out " + folder / "x.h5").status, 2);
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_THAT(entry.path().filename().string(), ::testing::Not(HasSubstr("x.h5")));
  }
}

}  // namespace
}  // namespace typodont
