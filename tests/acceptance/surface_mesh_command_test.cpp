// Tests `typodont mesh` as users run it: the program, its files, and its exit statuses.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>

#include "engine/base/json.h"
#include "tests/support/program.h"
#include "tests/support/surface_checks.h"

namespace typodont::surface {
namespace {

using namespace typodont::test;

class MeshCommand : public ::testing::Test {
 protected:
  Ran run(const std::string& arguments) const { return folder.run("mesh " + arguments); }
  /// Writes a scene of one enamel solid with voxels of 0.1 mm.
  std::string scene(const std::string& solid) {
    return folder.write(
        "scene.json",
        R"({"name": "solid", "tissue": {"voxel_mm": 0.1, "band_mm": 1.0, "solids": [{"tissue": "enamel", "solid": )" +
            solid + R"(}]}, "tool": "round_012"})");
  }
  /// Millimetres.
  WholeMesh read_ply(const std::string& file) {
    const std::string bytes = read_text(file);
    auto number_after = [&](const char* words) {
      return static_cast<std::size_t>(std::atol(bytes.c_str() + bytes.find(words) + std::strlen(words)));
    };
    WholeMesh mesh;
    mesh.vertices.resize(number_after("element vertex "));
    mesh.triangles.resize(number_after("element face "));
    const char* at = bytes.data() + bytes.find("end_header\n") + 11;
    for (auto& v : mesh.vertices) {
      std::memcpy(&v.position, at, 12);
      at += 28;
    }
    for (auto& t : mesh.triangles) {
      std::memcpy(t.data(), at + 1, 12);
      at += 13;
    }
    EXPECT_EQ(at, bytes.data() + bytes.size());
    return mesh;
  }

  ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(MeshCommand, DrilledPlateHasGenusOne) {
  const std::string file =
      scene(R"({"difference": [{"box": {"center_mm": [0,0,0], "size_mm": [6,5,1.5]}},)"
            R"({"cylinder": {"center_mm": [0,0,0], "axis": [0,0,1], "radius_mm": 1, "height_mm": 4}}]})");
  const Ran result = expect_ok(run(file + " --out " + (folder / "p.ply") + " --json"));
  const WholeMesh mesh = read_ply(folder / "p.ply");
  const test::Topology t = test::topology_of(mesh);
  EXPECT_TRUE(t.closed && t.oriented && t.manifold) << t.complaint;
  EXPECT_EQ(t.euler, 0);
  const Json report = Json::parse(result.out, "report");
  EXPECT_EQ(report["triangles"].integer(), static_cast<long long>(mesh.triangles.size()));
  EXPECT_NEAR(report["size_mm"].items()[0].number(), 6, 0.02);
  EXPECT_NEAR(report["size_mm"].items()[2].number(), 1.5, 0.02);
}

TEST_F(MeshCommand, OtherFormatsHoldTheSameTriangles) {
  const std::string file = scene(R"({"sphere": {"center_mm": [0,0,0], "radius_mm": 2}})");
  ASSERT_EQ(run(file + " --out " + (folder / "s.ply")).status, 0);
  ASSERT_EQ(run(file + " --out " + (folder / "s.stl")).status, 0);
  ASSERT_EQ(run(file + " --out " + (folder / "s.obj")).status, 0);
  const std::size_t triangles = read_ply(folder / "s.ply").triangles.size();
  EXPECT_EQ(read_text(folder / "s.stl").size(), 84 + 50 * triangles);
  const std::string text = read_text(folder / "s.obj");
  std::size_t faces = 0;
  for (std::size_t at = text.find("\nf "); at != std::string::npos; at = text.find("\nf ", at + 1)) ++faces;
  EXPECT_EQ(faces, triangles);
}

}  // namespace
}  // namespace typodont::surface
