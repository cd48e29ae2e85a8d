// Tests that the mesh after any sequence of updates equals the mesh of the present bricks.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "engine/surface/mesh_export.h"
#include "tests/support/campaign.h"
#include "tests/support/surface_block.h"
#include "tests/support/surface_checks.h"

namespace typodont::surface {
namespace {

using test::CutBlock;
using test::put;

TEST(Incremental, TheMeshAfterRandomCutsEqualsAFullRemesh) {
  EXPECT_EQ(test::cut_and_compare(test::campaign(500)), "");
}

TEST(Incremental, OnlyBricksNearTheCutAreRemeshed) {
  CutBlock block(4);
  SurfaceMesher mesher;
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  const std::vector<glm::ivec3> touched = block.cut({8, 8, 4}, 2);
  for (const glm::ivec3& key : touched) put(mesher, block.brick(key));
  for (const glm::ivec3& key : mesher.remesh()) {
    const bool near = std::any_of(touched.begin(), touched.end(), [&](const glm::ivec3& t) {
      const glm::ivec3 d = key - t;
      return glm::all(glm::greaterThanEqual(d, glm::ivec3(0))) && glm::all(glm::lessThanEqual(d, glm::ivec3(1)));
    });
    EXPECT_TRUE(near);
  }
  EXPECT_EQ(mesher.remesh().size(), 0u);
}

TEST(Incremental, SharedVerticesAreTheSameBitsInBothBricks) {
  CutBlock block(3);
  block.cut({24, 24, 40}, 7);
  SurfaceMesher mesher;
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  // If vertices are joined by exact position, the surface is closed: no vertex differs by even one bit across a border.
  struct Less {
    bool operator()(const glm::vec3& a, const glm::vec3& b) const {
      return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    }
  };
  std::map<glm::vec3, std::uint32_t, Less> number;
  WholeMesh mesh;
  for (const glm::ivec3& key : mesher.keys()) {
    const BrickMesh& part = *mesher.find(key);
    auto joined = [&](std::size_t i) {
      const glm::vec3& p = part.vertices[part.indices[i]].position;
      const auto [it, fresh] = number.try_emplace(p, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back({p, {}, Tissue::kAir});
      return it->second;
    };
    for (std::size_t i = 0; i < part.indices.size(); i += 3) {
      mesh.triangles.push_back({joined(i), joined(i + 1), joined(i + 2)});
    }
  }
  const auto t = test::topology_of(mesh);
  EXPECT_TRUE(t.closed && t.oriented) << t.complaint;
}

TEST(Incremental, BricksOfDifferentTolerancesJoinWithoutCracks) {
  CutBlock block(4);
  block.cut({33, 29, 40}, 11);
  SurfaceMesher mesher({.tolerance = 0.05f});
  const std::vector<glm::ivec3> keys = block.keys();
  for (const glm::ivec3& key : keys) put(mesher, block.brick(key));
  mesher.remesh();
  mesher.set_tolerance(0.4f);
  const std::size_t fine = test::triangle_count(mesher);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    put(mesher, block.brick(keys[i]));
    if (i % 7 != 0) continue;
    mesher.remesh();
    const auto t = test::topology_of(weld(mesher));
    ASSERT_TRUE(t.closed && t.oriented && t.manifold) << i << ": " << t.complaint;
  }
  mesher.remesh();
  EXPECT_LT(test::triangle_count(mesher), fine);
  SurfaceMesher coarse({.tolerance = 0.4f});
  for (const glm::ivec3& key : keys) put(coarse, block.brick(key));
  coarse.remesh();
  EXPECT_EQ(test::mesh_hash(mesher), test::mesh_hash(coarse));
}

TEST(Incremental, BricksWithoutSurfaceAreReportedOnceAndReleased) {
  CutBlock block(2);
  SurfaceMesher mesher;
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  EXPECT_EQ(mesher.keys().size(), 8u);
  for (const glm::ivec3& key : block.cut({16, 16, 16}, 40)) put(mesher, block.brick(key));
  EXPECT_EQ(mesher.remesh().size(), 8u);
  EXPECT_TRUE(mesher.keys().empty());
  EXPECT_EQ(test::triangle_count(mesher), 0u);
  EXPECT_EQ(mesher.remesh().size(), 0u);
}

}  // namespace
}  // namespace typodont::surface
