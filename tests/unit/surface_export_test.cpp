#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "engine/base/base64.h"
#include "engine/surface/mesh_export.h"
#include "tests/support/folder.h"
#include "tests/support/surface_checks.h"

namespace typodont::surface {
namespace {

using test::mesh_of;
using test::sample_bricks;

class Export : public ::testing::Test {
 protected:
  void SetUp() override {
    // An enamel ball of 0.6 mm whose lower half is dentin.
    const auto ball = [](const glm::dvec3& p) { return glm::length(p - 10.3) - 6; };
    const auto labels = [](const glm::dvec3& p) { return p.z < 10 ? Tissue::kDentin : Tissue::kEnamel; };
    mesh_ = weld(mesh_of(sample_bricks(glm::dvec3(0), glm::dvec3(20), ball, labels), 0.05f));
    materials_[static_cast<int>(Tissue::kEnamel)].color = {1, 1, 0.9};
    materials_[static_cast<int>(Tissue::kDentin)].color = {0.9, 0.8, 0.5};
  }

  std::string written(const char* name) {
    write_mesh(folder_ / name, mesh_, frame_, materials_);
    return test::read_text(folder_ / name);
  }
  template <class T>
  static T read(const std::string& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  }

  TemporaryFolder own_;
  const std::filesystem::path folder_ = own_.path();
  WholeMesh mesh_;
  MaterialTable materials_{};
  VoxelFrame frame_{{0.001, 0, 0}, 1e-4};
};

TEST_F(Export, PlyHoldsEveryVertexWithItsTissueAndColour) {
  const std::string bytes = written("ball.ply");
  const std::size_t head = bytes.find("end_header\n") + 11;
  EXPECT_NE(bytes.find("element vertex " + std::to_string(mesh_.vertices.size()) + "\n"), std::string::npos);
  EXPECT_NE(bytes.find("element face " + std::to_string(mesh_.triangles.size()) + "\n"), std::string::npos);
  ASSERT_EQ(bytes.size(), head + 28 * mesh_.vertices.size() + 13 * mesh_.triangles.size());
  int enamel = 0, dentin = 0;
  for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
    const std::size_t at = head + 28 * i;
    const glm::dvec3 p(read<float>(bytes, at), read<float>(bytes, at + 4), read<float>(bytes, at + 8));
    EXPECT_NEAR(glm::length(p - glm::dvec3(1 + 1.03, 1.03, 1.03)), 0.6, 0.006);  // millimetres
    const auto tissue = read<Tissue>(bytes, at + 27);
    (tissue == Tissue::kEnamel ? enamel : dentin) += 1;
    EXPECT_EQ(read<std::uint8_t>(bytes, at + 26), tissue == Tissue::kEnamel ? 230 : 128);  // blue
    // Labels change between the samples at 0.9 and 1.0 mm.
    EXPECT_EQ(tissue, p.z < 0.85 ? Tissue::kDentin : p.z > 1.05 ? Tissue::kEnamel : tissue);
  }
  EXPECT_GT(enamel, 20);
  EXPECT_GT(dentin, 20);
}

TEST_F(Export, StlFacetsPointOutward) {
  const std::string bytes = written("ball.STL");
  ASSERT_EQ(bytes.size(), 84 + 50 * mesh_.triangles.size());
  EXPECT_EQ(read<std::uint32_t>(bytes, 80), mesh_.triangles.size());
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    glm::vec3 v[4];
    std::memcpy(v, bytes.data() + 84 + 50 * i, sizeof v);
    const glm::vec3 centre(2.03f, 1.03f, 1.03f);
    if (glm::length(v[0]) > 0) {
      EXPECT_GT(glm::dot(v[0], (v[1] + v[2] + v[3]) / 3.f - centre), 0);
    }
  }
}

TEST_F(Export, ObjIsTheSameMeshAsText) {
  const std::string ply = written("ball.ply");
  const std::size_t vertices = ply.find("end_header\n") + 11;
  std::istringstream in(written("ball.obj"));
  std::string line, kind;
  std::size_t positions = 0, normals = 0, faces = 0;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    words >> kind;
    if (glm::vec3 p; kind == "v") {
      ASSERT_TRUE(words >> p.x >> p.y >> p.z);
      for (int k = 0; k < 3; ++k) ASSERT_EQ(p[k], read<float>(ply, vertices + 28 * positions + 4 * k));
      ++positions;
    } else if (glm::vec3 n; kind == "vn") {
      ASSERT_TRUE(words >> n.x >> n.y >> n.z);
      ASSERT_LT(glm::length(n - mesh_.vertices.at(normals++).normal), 1e-5);
    } else if (kind == "f") {
      const auto& [a, b, c] = mesh_.triangles.at(faces++);
      ASSERT_EQ(line, fmt::format("f {0}//{0} {1}//{1} {2}//{2}", a + 1, b + 1, c + 1));
    }
  }
  EXPECT_EQ(positions, mesh_.vertices.size());
  EXPECT_EQ(normals, mesh_.vertices.size());
  EXPECT_EQ(faces, mesh_.triangles.size());
}

TEST_F(Export, GlbContainsTheMeshInMetresWithColours) {
  const std::string bytes = written("ball.glb");
  ASSERT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(read<std::uint32_t>(bytes, 4), 2U);
  EXPECT_EQ(read<std::uint32_t>(bytes, 8), bytes.size());
  const auto length = read<std::uint32_t>(bytes, 12);
  ASSERT_EQ(length % 4, 0U);
  const nlohmann::json json = nlohmann::json::parse(bytes.substr(20, length));
  const std::size_t buffer = 20 + length + 8, n = mesh_.vertices.size();
  EXPECT_EQ(read<std::uint32_t>(bytes, buffer - 8), bytes.size() - buffer);
  EXPECT_EQ(json["buffers"][0]["byteLength"], bytes.size() - buffer);
  EXPECT_EQ(json["accessors"][0]["count"], n);
  EXPECT_EQ(json["accessors"][3]["count"], 3 * mesh_.triangles.size());
  const auto start = [&](int view) { return buffer + json["bufferViews"][view]["byteOffset"].get<std::size_t>(); };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t at = start(0) + 12 * i;
    const glm::dvec3 p(read<float>(bytes, at), read<float>(bytes, at + 4), read<float>(bytes, at + 8));
    EXPECT_NEAR(glm::length(1e3 * p - glm::dvec3(1 + 1.03, 1.03, 1.03)), 0.6, 0.006);
    const auto blue = read<std::uint8_t>(bytes, start(2) + 4 * i + 2);
    EXPECT_EQ(blue, mesh_.vertices[i].tissue == Tissue::kEnamel ? 230 : 128);
  }
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(read<std::uint32_t>(bytes, start(3) + 12 * i + 4 * k), mesh_.triangles[i][k]);
  }
}

TEST_F(Export, GltfIsTheSameMeshInOneTextFile) {
  nlohmann::json text = nlohmann::json::parse(written("ball.gltf"));
  const std::string binary = written("ball.glb");
  const auto length = read<std::uint32_t>(binary, 12);
  const std::vector<std::uint8_t> buffer(binary.begin() + 20 + length + 8, binary.end());
  EXPECT_EQ(text["buffers"][0]["uri"].get<std::string>(), "data:application/octet-stream;base64," + base64(buffer));
  text["buffers"][0].erase("uri");
  EXPECT_EQ(text, nlohmann::json::parse(binary.substr(20, length))) << "all but the place of the buffer";
}

TEST_F(Export, UnknownFormatIsRefusedByName) {
  EXPECT_THAT(test::refusal([&] { write_mesh(folder_ / "ball.fbx", mesh_, frame_, materials_); }),
              testing::AllOf(testing::HasSubstr("ball.fbx"), testing::HasSubstr(".ply, .stl, .obj, .glb or .gltf")));
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace typodont::surface
