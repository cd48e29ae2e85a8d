// Tests the surface of a volume as a mesh: its position, the order of its corners, and its labels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>

#include "engine/base/json.h"
#include "haptics/solid.h"
#include "haptics/tissue_mesh.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {
namespace {

TissueVolume volume(std::string_view json) {
  return TissueVolume(read_solids(Json::parse(json, "test")));
}

constexpr std::string_view kTwoHalves = R"({"voxel_mm": 0.1, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}},
  {"tissue": "dentin", "solid": {"intersection": [{"sphere": {"radius_mm": 3}},
    {"halfspace": {"normal": [1, 0, 0], "offset_mm": 0}}]}}]})";

TEST(SurfaceMesh, LiesOnTheZeroSetOfTheField) {
  const TissueMesh mesh = surface_mesh(volume(kTwoHalves));
  ASSERT_GT(mesh.vertices.size(), 10'000U);
  double worst = 0;
  for (const dvec3& p : mesh.vertices) worst = std::max(worst, std::abs(glm::length(p) - 3e-3));
  EXPECT_LT(worst, 0.01 * 0.1e-3);
}

TEST(SurfaceMesh, IsClosedAndWoundOutwards) {
  const TissueMesh mesh = surface_mesh(volume(kTwoHalves));
  std::map<std::array<unsigned, 2>, int> edges;
  double six = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const unsigned a = t[k], b = t[(k + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
    six += glm::dot(mesh.vertices[t.x], glm::cross(mesh.vertices[t.y], mesh.vertices[t.z]));
  }
  EXPECT_TRUE(std::ranges::all_of(edges, [](const auto& e) { return e.second == 0; }));
  EXPECT_NEAR(six / 6 / (4.0 / 3 * 3.14159265358979 * 27e-9), 1, 2e-3);  // flat faces lie inside
}

TEST(SurfaceMesh, EveryFaceHasTheTissueBelowIt) {
  const TissueMesh mesh = surface_mesh(volume(kTwoHalves));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const double x = (mesh.vertices[t.x].x + mesh.vertices[t.y].x + mesh.vertices[t.z].x) / 3;
    if (std::abs(x) < 0.15e-3) continue;  // within a voxel or so of the border
    EXPECT_EQ(mesh.tissue[i], x < 0 ? Tissue::kDentin : Tissue::kEnamel) << x;
  }
}

TEST(SurfaceMesh, OfAVolumeFromAMeshIsThatMeshAndPaintingChangesItsLabels) {
  TissueVolume tissue = volume(kTwoHalves);
  auto mesh = std::make_shared<TissueMesh>();
  mesh->vertices = {{0, 0, 3e-3}, {1e-3, 0, 2.8e-3}, {0, 1e-3, 2.8e-3}};
  mesh->triangles = {{0, 1, 2}};
  mesh->tissue = {Tissue::kEnamel};
  tissue.set_mesh(mesh);
  EXPECT_EQ(surface_mesh(tissue.clone()).triangles.size(), 1U);
  tissue.paint(Tissue::kCaries, *capsule({0, 0, 3e-3}, {0, 0, 3e-3}, 1e-3));
  EXPECT_EQ(surface_mesh(tissue).tissue, std::vector<Tissue>{Tissue::kCaries});
  EXPECT_EQ(mesh->tissue, std::vector<Tissue>{Tissue::kEnamel});
}

}  // namespace
}  // namespace typodont::haptics
