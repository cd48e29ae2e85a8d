// Tests the editable mesh: properties that its edits preserve, checked by counting and by direct computation.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "haptics/mesh/near_points.h"
#include "haptics/mesh/spatial_order.h"
#include "tests/support/mesh_shapes.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::TissueMesh;
using haptics::mesh::EditableMesh;
using haptics::mesh::Index;
using haptics::mesh::kNone;
using haptics::mesh::MeshRecord;
using test::ball;
using test::broken;
using test::random_edits;
using test::square;

constexpr double kEdge = 0.5e-3;  // m

int euler(const EditableMesh& mesh) {
  const auto borders = mesh.border_edges();
  const auto edges = (3 * mesh.face_count() + borders) / 2;
  return static_cast<int>(mesh.vertex_count()) - static_cast<int>(edges) + static_cast<int>(mesh.face_count());
}

TEST(EditableMesh, RandomEditsKeepItAManifoldOfTheSameKindWithTheSameBorder) {
  for (const bool open : {false, true}) {
    EditableMesh mesh(open ? square(5.0_mm, kEdge) : ball(dvec3(3.0_mm), kEdge), kEdge, 5000);
    ASSERT_EQ(broken(mesh), "");
    const std::size_t border = mesh.border_edges();
    EXPECT_EQ(border > 0, open);
    EXPECT_EQ(euler(mesh), open ? 1 : 2);
    std::mt19937 random(7);
    for (int round = 0; round < 20; ++round) {
      random_edits(mesh, random, 500);
      ASSERT_EQ(broken(mesh), "") << round;
      ASSERT_EQ(mesh.border_edges(), border);
      ASSERT_EQ(euler(mesh), open ? 1 : 2);
    }
  }
}

/// True if one of 15 points of the triangle is in the box.
bool reaches_into(const haptics::mesh::Corners& t, const dvec3& lo, const dvec3& hi) {
  constexpr int kParts = 4;
  for (int i = 0; i <= kParts; ++i)
    for (int j = 0; i + j <= kParts; ++j) {
      const dvec3 p = (double(i) * t.p[0] + double(j) * t.p[1] + double(kParts - i - j) * t.p[2]) / double(kParts);
      if (glm::clamp(p, lo, hi) == p) return true;
    }
  return false;
}

TEST(EditableMesh, TheGridFindsEveryFaceThatReachesIntoABox) {
  EditableMesh mesh(ball(dvec3(3.0_mm, 2.0_mm, 4.0_mm), kEdge), 0.25 * kEdge, 5000);
  std::mt19937 random(3);
  random_edits(mesh, random, 4000);
  for (int k = 0; k < 200; ++k) {
    std::uniform_real_distribution<double> place(-4e-3, 4e-3), size(0, 1e-3);
    const dvec3 lo(place(random), place(random), place(random)),
        hi = lo + dvec3(size(random), size(random), size(random));
    std::vector<int> found(mesh.face_range());
    mesh.near(lo, hi, [&](Index f) { ++found[f]; });
    for (Index f = 0; f < mesh.face_range(); ++f) {
      if (!mesh.uses(f)) {
        ASSERT_EQ(found[f], 0);
        continue;
      }
      ASSERT_LE(found[f], 1);
      if (reaches_into(haptics::mesh::corners(mesh, f), lo, hi)) {
        ASSERT_EQ(found[f], 1) << f;
      }
    }
  }
}

TEST(EditableMesh, RoughNormalsFollowEveryEdit) {
  std::mt19937 random(17);
  EditableMesh mesh(ball(dvec3(5.0_mm), kEdge), kEdge, 4000);
  MeshRecord record;
  const auto check = [&](const EditableMesh& m) {
    for (Index f = 0; f < m.face_range(); ++f) {
      if (!m.uses(f)) continue;
      const dvec3 n = glm::cross(m.point(f, 1) - m.point(f, 0), m.point(f, 2) - m.point(f, 0));
      const dvec3 unit = glm::length(n) > 1e-40 ? glm::normalize(n) : dvec3(0);
      ASSERT_LE(glm::distance(dvec3(m.rough_normal(f)), unit), static_cast<double>(EditableMesh::kRoughNormalError));
    }
  };
  for (int round = 0; round < 10; ++round) {
    record = {};
    mesh.record(&record);
    random_edits(mesh, random, 300);
    mesh.record(nullptr);
    check(mesh);
    check(EditableMesh(mesh));
    if (round % 3 == 0) mesh.exchange(record), check(mesh);
  }
}

TEST(NearPoints, FindsEveryPointWithinReachAndNoneFarBeyond) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  haptics::mesh::NearPoints points(1000);
  for (const int count : {0, 1, 7, 8, 9, 500, 1000}) {
    const dvec3 center(0.04, -0.02, 0.03);
    points.clear({center, dquat(1, 0, 0, 0)});
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(points.add(center + 2e-3 * dvec3(unit(random), unit(random), unit(random))));
    }
    for (int look = 0; look < 20; ++look) {
      const dvec3 p = center + 1e-3 * dvec3(unit(random), unit(random), unit(random));
      const double reach = 1e-3 * std::abs(unit(random));
      const auto found = points.within(p, reach);
      std::size_t next = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double distance = glm::distance(points[i], p);
        const bool listed = next < found.size() && found[next] == i;
        next += listed;
        ASSERT_TRUE(listed || distance > reach) << i;
        ASSERT_TRUE(!listed || distance < reach + 1e-7) << i;
      }
      ASSERT_EQ(next, found.size());
    }
  }
  EXPECT_TRUE(points.full());
  EXPECT_FALSE(points.add(dvec3(0)));
}

TEST(EditableMesh, WithoutRoomNothingIsSplit) {
  EditableMesh mesh(ball(dvec3(3.0_mm), kEdge), kEdge, 3);
  int done = 0;
  for (Index f = 0; f < 50; ++f) done += mesh.split(f, 0, 0.5 * (mesh.point(f, 0) + mesh.point(f, 1))) != kNone;
  EXPECT_EQ(done, 3);
  EXPECT_EQ(broken(mesh), "");
}

TEST(EditableMesh, NonManifoldEdgesAndVerticesAreSplit) {
  // Three triangles have one edge in common, and two triangles have one vertex in common.
  TissueMesh fin;
  fin.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  fin.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  fin.tissue.assign(3, Tissue::kEnamel);
  const EditableMesh apart(fin, 1, 0);
  EXPECT_EQ(broken(apart), "");
  EXPECT_EQ(apart.border_edges(), 9u);
  EXPECT_EQ(apart.vertex_count(), 9u);
  TissueMesh tie;
  tie.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  tie.triangles = {{0, 1, 2}, {0, 3, 4}};
  tie.tissue.assign(2, Tissue::kEnamel);
  const EditableMesh two(tie, 1, 0);
  EXPECT_EQ(broken(two), "");
  EXPECT_EQ(two.vertex_count(), 6u);
}

TEST(EditableMesh, IntersectingTrianglesAreDetectedAndTouchingOnesAreNot) {
  using haptics::mesh::Corners;
  using haptics::mesh::cross_each_other;
  const Corners flat{{0, 1, 2}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  EXPECT_TRUE(cross_each_other(flat, {{3, 4, 5}, {{0.2, 0.2, -1}, {0.3, 0.2, 1}, {0.2, 0.3, 1}}}));
  EXPECT_FALSE(cross_each_other(flat, {{3, 4, 5}, {{0.2, 0.2, 0}, {0.3, 0.2, 1}, {0.2, 0.3, 1}}}));
  EXPECT_FALSE(cross_each_other(flat, {{0, 1, 5}, {{0, 0, 0}, {1, 0, 0}, {0.2, 0.3, 1}}}));
  EXPECT_TRUE(cross_each_other(flat, {{0, 4, 5}, {{0, 0, 0}, {0.3, 0.3, 0.5}, {0.35, 0.3, -0.5}}})) << "one in common";
  EXPECT_FALSE(cross_each_other(flat, {{0, 4, 5}, {{0, 0, 0}, {-0.3, 0.3, 0.5}, {-0.3, 0.3, -0.5}}}));
}

TEST(NearPoints, KeepsTheListedPointsAndThoseBeforeTheFirstIndex) {
  haptics::mesh::NearPoints points(10);
  points.clear(Pose{});
  for (int i = 0; i < 8; ++i) points.add({1e-3 * i, 0, 0});
  const std::uint32_t kept[] = {3, 4, 7};
  const double distances[] = {1e-3, 2e-3, 3e-3};
  points.keep(2, kept, distances);
  ASSERT_EQ(points.size(), 5u);
  const double expected[] = {0, 1e-3, 3e-3, 4e-3, 7e-3};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_DOUBLE_EQ(points[i].x, expected[i]);
  const auto near = points.within({7e-3, 0, 0}, 1e-4);
  ASSERT_EQ(near.size(), 1u) << "the search uses the new indices";
  EXPECT_EQ(near[0], 4u);
  const auto listed = points.listed_within(2e-3);
  const std::vector<std::uint32_t> without_distance_or_near = {0, 1, 2, 3};
  EXPECT_EQ(std::vector<std::uint32_t>(listed.begin(), listed.end()), without_distance_or_near);
}

TEST(SpatialOrder, KeepsEveryTriangleWithItsTissueAndSortsNeighboursTogether) {
  haptics::TissueMesh mesh = test::ball(dvec3(3e-3), 0.3e-3);
  std::mt19937 random(4);
  std::vector<std::size_t> shuffled(mesh.triangles.size());
  std::iota(shuffled.begin(), shuffled.end(), 0);
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  haptics::TissueMesh mixed = mesh;
  for (std::size_t i = 0; i < shuffled.size(); ++i) {
    mixed.triangles[i] = mesh.triangles[shuffled[i]];
    mixed.tissue[i] = i % 3 ? Tissue::kEnamel : Tissue::kDentin;
  }
  const haptics::TissueMesh sorted = haptics::mesh::in_spatial_order(mixed);
  const auto content = [](const haptics::TissueMesh& m) {
    std::multiset<std::tuple<unsigned, unsigned, unsigned, Tissue>> all;
    for (std::size_t i = 0; i < m.triangles.size(); ++i) {
      all.emplace(m.triangles[i].x, m.triangles[i].y, m.triangles[i].z, m.tissue[i]);
    }
    return all;
  };
  EXPECT_EQ(content(sorted), content(mixed));
  EXPECT_EQ(sorted.vertices, mixed.vertices);
  const auto mean_leap = [](const haptics::TissueMesh& m) {
    double sum = 0;
    for (std::size_t i = 1; i < m.triangles.size(); ++i) {
      sum += glm::distance(m.vertices[m.triangles[i].x], m.vertices[m.triangles[i - 1].x]);
    }
    return sum / static_cast<double>(m.triangles.size() - 1);
  };
  EXPECT_LT(mean_leap(sorted), 0.2 * mean_leap(mixed));
}

}  // namespace
}  // namespace typodont
