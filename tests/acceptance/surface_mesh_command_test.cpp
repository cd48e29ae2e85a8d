// Tests `typodont mesh` as users run it: the program, its files, and its exit statuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "engine/base/json.h"
#include "tests/support/surface_checks.h"

namespace typodont::surface {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class MeshCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("typodont_mesh_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  struct Result {
    int status;
    std::string out, err;
  };
  Result run(const std::string& arguments) {
    const std::string out = path("stdout"), err = path("stderr");
    const std::string line = std::string(TYPODONT_PROGRAM) + " mesh " + arguments + " > " + out + " 2> " + err;
    const int status = std::system(line.c_str());
    return {WEXITSTATUS(status), read(out), read(err)};
  }
  std::string path(const std::string& name) { return (folder_ / name).string(); }
  std::string read(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// Writes a scene of one enamel solid with voxels of 0.1 mm.
  std::string scene(const std::string& solid) {
    const std::string file = path("scene.json");
    std::ofstream(file) << R"({"name": "solid", "tissue": {"voxel_mm": 0.1, "band_mm": 1.0, "solids": [)"
                        << R"({"tissue": "enamel", "solid": )" << solid << R"(}]}, "tool": "round_012"})";
    return file;
  }
  /// Millimetres.
  WholeMesh read_ply(const std::string& file) {
    const std::string bytes = read(file);
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

  std::filesystem::path folder_;
};

TEST_F(MeshCommand, ASphereIsClosedWithinToleranceAndHasFewTriangles) {
  const std::string file = scene(R"({"sphere": {"center_mm": [0.03, -0.02, 0.04], "radius_mm": 3}})");
  for (const double tolerance : {0.002, 0.01, 0.02}) {
    const Result result = run(file + " --out " + path("s.ply") + " --tolerance-mm " + std::to_string(tolerance));
    ASSERT_EQ(result.status, 0) << result.err;
    const WholeMesh mesh = read_ply(path("s.ply"));
    const test::Topology t = test::topology_of(mesh);
    EXPECT_TRUE(t.closed && t.oriented && t.manifold) << t.complaint;
    EXPECT_EQ(t.euler, 2);
    const double error = test::largest_error(
        mesh, [](const glm::dvec3& p) { return glm::length(p - glm::dvec3(0.03, -0.02, 0.04)) - 3; });
    EXPECT_LT(error, tolerance);
    EXPECT_LT(static_cast<double>(mesh.triangles.size()) * error / 3, 7.3) << tolerance;
  }
}

TEST_F(MeshCommand, DrilledPlateHasGenusOne) {
  const std::string file =
      scene(R"({"difference": [{"box": {"center_mm": [0,0,0], "size_mm": [6,5,1.5]}},)"
            R"({"cylinder": {"center_mm": [0,0,0], "axis": [0,0,1], "radius_mm": 1, "height_mm": 4}}]})");
  const Result result = run(file + " --out " + path("p.ply") + " --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const WholeMesh mesh = read_ply(path("p.ply"));
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
  ASSERT_EQ(run(file + " --out " + path("s.ply")).status, 0);
  ASSERT_EQ(run(file + " --out " + path("s.stl")).status, 0);
  ASSERT_EQ(run(file + " --out " + path("s.obj")).status, 0);
  const std::size_t triangles = read_ply(path("s.ply")).triangles.size();
  EXPECT_EQ(read(path("s.stl")).size(), 84 + 50 * triangles);
  const std::string text = read(path("s.obj"));
  std::size_t faces = 0;
  for (std::size_t at = text.find("\nf "); at != std::string::npos; at = text.find("\nf ", at + 1)) ++faces;
  EXPECT_EQ(faces, triangles);
}

TEST_F(MeshCommand, BadInputIsRefusedByNameAndLeavesNoFile) {
  const std::string file = scene(R"({"sphere": {"center_mm": [0,0,0], "radius_mm": 2}})");
  Result result = run(file + " --out " + path("s.xyz"));
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, AllOf(HasSubstr("s.xyz"), HasSubstr(".stl")));
  result = run(path("nowhere.vdb") + " --out " + path("s.ply"));
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("nowhere.vdb"));
  result = run(file + " --out " + path("s.ply") + " --tolerance-mm -1");
  EXPECT_EQ(result.status, 2);
  result = run(file + " --out " + path("no/such/folder/s.ply"));
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("no/such/folder"));
  EXPECT_FALSE(std::filesystem::exists(path("s.ply")));
  EXPECT_FALSE(std::filesystem::exists(path("s.xyz")));
}

}  // namespace
}  // namespace typodont::surface
