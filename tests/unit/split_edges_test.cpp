// Tests the splitting of long edges in the meshes of the surroundings and of the soft gum.
#include "engine/app/tissue/split_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

namespace typodont {
namespace {

/// Returns a brick with `count` random triangles in the plane z = 0 that share the corner `first`.
render::MeshUpdate fan(std::uint32_t seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> size(0.5f, 6.0f);
  render::MeshUpdate mesh;
  mesh.vertices.resize(static_cast<std::size_t>(count) + 2);
  for (std::size_t i = 1; i < mesh.vertices.size(); ++i) {
    const float angle = 0.2f * static_cast<float>(i), r = size(random);
    mesh.vertices[i].p = {r * std::cos(angle), r * std::sin(angle), 0};
    mesh.vertices[i].n = {0, 0, 1};
  }
  for (std::uint32_t i = 1; i + 1 < mesh.vertices.size(); ++i) mesh.indices.insert(mesh.indices.end(), {0, i, i + 1});
  return mesh;
}
bool is_long(const render::Vertex& a, const render::Vertex& b) {
  return glm::length(a.p - b.p) > 1;
}
double area(const render::MeshUpdate& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) { return dvec3(mesh.vertices[mesh.indices[i + k]].p); };
    sum += 0.5 * glm::cross(at(1) - at(0), at(2) - at(0)).z;  // negative if a triangle is turned over
  }
  return sum;
}

TEST(SplitEdges, LeavesNoLongEdgeAndKeepsTheAreaOfEachShape) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    render::MeshUpdate mesh = fan(seed, 12);
    const double before = area(mesh);
    while (split_edges(mesh, is_long)) {
    }
    EXPECT_NEAR(area(mesh), before, 1e-4 * before) << seed;
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
      const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
      ASSERT_FALSE(is_long(mesh.vertices[mesh.indices[i]], mesh.vertices[mesh.indices[next]])) << seed;
    }
  }
}

TEST(SplitEdges, TwoBricksThatShareAnEdgeSplitItAtTheSamePoints) {
  // The bricks share the edge between the corners a and b, in opposite directions.
  const glm::vec3 a(0.3f, -0.2f, 0.1f), b(4.7f, 3.1f, 0.9f);
  const auto points_on_edge = [&](const glm::vec3& apex, bool turned) {
    render::MeshUpdate mesh;
    mesh.vertices.resize(3);
    mesh.vertices[0].p = turned ? b : a, mesh.vertices[1].p = turned ? a : b, mesh.vertices[2].p = apex;
    mesh.indices = {0, 1, 2};
    while (split_edges(mesh, is_long)) {
    }
    std::vector<std::tuple<float, float, float>> found;
    for (const render::Vertex& v : mesh.vertices)
      if (glm::length(glm::cross(v.p - a, b - a)) < 1e-4f) found.emplace_back(v.p.x, v.p.y, v.p.z);
    std::sort(found.begin(), found.end());
    return found;
  };
  const auto one = points_on_edge({-3, 5, 0}, false), other = points_on_edge({5, -1, 2}, true);
  EXPECT_GT(one.size(), 5u);
  EXPECT_EQ(one, other);
}

}  // namespace
}  // namespace typodont
