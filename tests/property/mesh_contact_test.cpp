// Tests of contact with triangle meshes: the surface contact point, levels of detail, and walls between tissues.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "engine/base/units.h"
#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/contact/mesh_lod/mesh_lod_model.h"
#include "haptics/contact/mesh_lod/surface_point.h"
#include "haptics/import/mesh_tissue.h"
#include "tests/support/campaign.h"
#include "tests/support/hausdorff.h"

namespace typodont::haptics::mesh_lod {
namespace {

using namespace literals;

constexpr double kSkin = SurfacePoint::kSkin;

Stiffness even_stiffness() {
  Stiffness all;
  all.fill(1000);
  return all;
}
SurfacePoint point(double radius = 0) {
  SurfaceOptions options;
  options.radius = radius;
  return SurfacePoint(options, even_stiffness());
}

void add(TissueMesh& mesh, const dvec3& a, const dvec3& b, const dvec3& c, Tissue tissue = Tissue::kEnamel) {
  const auto first = static_cast<unsigned>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.tissue.push_back(tissue);
}
/// Returns the mesh in which corners at the same position become one vertex.
TissueMesh welded(const TissueMesh& soup) {
  TissueMesh mesh;
  mesh.tissue = soup.tissue;
  const auto less = [](const dvec3& a, const dvec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
  std::map<dvec3, unsigned, decltype(less)> known(less);
  for (const glm::uvec3& t : soup.triangles) {
    glm::uvec3 u;
    for (int k = 0; k < 3; ++k) {
      const auto [it, fresh] = known.try_emplace(soup.vertices[t[k]], static_cast<unsigned>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back(soup.vertices[t[k]]);
      u[k] = it->second;
    }
    mesh.triangles.push_back(u);
  }
  return mesh;
}
/// Adds a parallelogram of n × n cells from `corner` along u and v. Its normal is u × v.
void add_sheet(TissueMesh& soup, const dvec3& corner, const dvec3& u, const dvec3& v, int n,
               Tissue tissue = Tissue::kEnamel) {
  const auto at = [&](int i, int j) {
    return corner + static_cast<double>(i) / n * u + static_cast<double>(j) / n * v;
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      add(soup, at(i, j), at(i + 1, j), at(i + 1, j + 1), tissue);
      add(soup, at(i, j), at(i + 1, j + 1), at(i, j + 1), tissue);
    }
  }
}

TEST(SurfacePoint, OnAPlaneIsTheProjectionOfTheHand) {
  TissueMesh soup;
  add_sheet(soup, {-5e-3, -5e-3, 0}, {10e-3, 0, 0}, {0, 10e-3, 0}, 20);
  const TriangleGrid grid(welded(soup));
  for (const double radius : {0.0, 0.125e-3, 0.6e-3}) {
    SurfacePoint p = point(radius);
    ASSERT_TRUE(p.put(grid, {0, 0, 2e-3}));
    p.follow(grid, {0, 0, -1e-3});
    ASSERT_TRUE(p.touching());
    for (int i = 1; i <= 300; ++i) {
      const dvec3 hand(10e-6 * i, 3e-6 * i, -0.5e-3);
      p.follow(grid, hand);
      ASSERT_NEAR(glm::distance(p.place(), {hand.x, hand.y, p.radius()}), 0, 1e-9) << i << " radius " << radius;
    }
    p.follow(grid, {0, 0, 1e-3});
    EXPECT_FALSE(p.touching());
  }
}

TEST(SurfacePoint, InACreaseIsOnTheCreaseLine) {
  // Two planes at an angle of 100°, with the crease along y.
  const double a = 50 * kPi / 180;
  const dvec3 left(-std::sin(a), 0, std::cos(a)), right(std::sin(a), 0, std::cos(a));
  TissueMesh soup;
  add_sheet(soup, {0, -5e-3, 0}, 5e-3 * right, {0, 10e-3, 0}, 25);
  add_sheet(soup, dvec3(0, -5e-3, 0) + 5e-3 * left, -5e-3 * left, {0, 10e-3, 0}, 25);
  const TriangleGrid grid(welded(soup));
  for (const double radius : {0.0, 0.125e-3}) {
    SurfacePoint p = point(radius);
    p.put(grid, {0, 0, 2e-3});
    for (int i = 0; i <= 200; ++i) {
      p.follow(grid, {0.05e-3 * std::sin(0.1 * i), 10e-6 * i, -0.5e-3});
      ASSERT_NEAR(glm::distance(p.place(), {0, 10e-6 * i, p.radius() / std::sin(a)}), 0, 1e-9) << i;
    }
    EXPECT_EQ(p.count(), 2);
  }
}

TEST(SurfacePoint, InACornerIsTheCornerPoint) {
  TissueMesh soup;
  add_sheet(soup, {0, 0, 0}, {4e-3, 0, 0}, {0, 4e-3, 0}, 11);
  add_sheet(soup, {0, 0, 0}, {0, 4e-3, 0}, {0, 0, 4e-3}, 11);
  add_sheet(soup, {0, 0, 0}, {0, 0, 4e-3}, {4e-3, 0, 0}, 11);
  const TriangleGrid grid(welded(soup));
  for (const double radius : {0.0, 0.125e-3}) {
    SurfacePoint p = point(radius);
    p.put(grid, dvec3(1e-3));
    p.follow(grid, dvec3(-0.3e-3, -0.2e-3, -0.4e-3));
    EXPECT_NEAR(glm::distance(p.place(), dvec3(p.radius())), 0, 1e-9);
    EXPECT_EQ(p.count(), 3);
  }
}

TEST(SurfacePoint, OfABallRollsOverAnEdgeAndACornerContinuously) {
  // The block has its top at z = 0 and an edge along y at x = 0. Its tissue is where x < 0 and z < 0.
  TissueMesh soup;
  add_sheet(soup, {-4e-3, -4e-3, 0}, {4e-3, 0, 0}, {0, 4e-3, 0}, 9);
  add_sheet(soup, {0, -4e-3, 0}, {0, 0, -4e-3}, {0, 4e-3, 0}, 9);
  add_sheet(soup, {-4e-3, 0, 0}, {4e-3, 0, 0}, {0, 0, -4e-3}, 9);  // the side at y = 0
  const TriangleGrid grid(welded(soup));
  const double r = 0.3e-3;
  SurfacePoint p = point(r);
  p.put(grid, {-0.2e-3, -1e-3, 1e-3});
  for (double angle = 89; angle >= 1; angle -= 1) {
    const dvec3 out(std::cos(angle * kPi / 180), 0, std::sin(angle * kPi / 180));
    p.follow(grid, dvec3(0, -1e-3, 0) + 0.2e-3 * out);
    ASSERT_NEAR(glm::distance(p.place(), dvec3(0, -1e-3, 0) + r * out), 0, 1e-9) << angle;
  }
  p.put(grid, {0.5e-3, 0.5e-3, 0.5e-3});
  const dvec3 out = glm::normalize(dvec3(1, 2, 3));
  p.follow(grid, 0.1e-3 * out);
  EXPECT_NEAR(glm::distance(p.place(), r * out), 0, 1e-9);
}

TEST(SurfacePoint, LeavesASheetAtItsBorder) {
  TissueMesh soup;
  add_sheet(soup, {-2e-3, -2e-3, 0}, {4e-3, 0, 0}, {0, 4e-3, 0}, 7);
  const TriangleGrid grid(welded(soup));
  SurfacePoint p = point();
  p.put(grid, {1.5e-3, 0, 1e-3});
  p.follow(grid, {1.5e-3, 0, -0.3e-3});
  EXPECT_TRUE(p.touching());
  p.follow(grid, {1.9e-3, 0, -0.3e-3});
  EXPECT_TRUE(p.touching());
  for (double x = 1.91e-3; x < 2.3e-3; x += 20e-6) p.follow(grid, {x, 0, -0.3e-3});
  EXPECT_FALSE(p.touching());
  EXPECT_NEAR(glm::distance(p.place(), {2.29e-3, 0, -0.3e-3}), 0, 30e-6);
}

// --- Bad meshes

/// Returns a star-shaped ball with a rough surface and with defects as in real files: slivers, faces without area,
/// copies of faces, and cracks below the surface.
TissueMesh bad_ball(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const int rings = 3 + static_cast<int>(3 * unit(random)), sectors = 4 + static_cast<int>(4 * unit(random));
  const double roughness = 0.4 * unit(random), sliver = unit(random) < 0.5 ? 1e-6 : 1;
  std::vector<dvec3> place;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      double a = kPi * i / rings;
      if (i > 0 && i < rings) a += 0.3 / rings * (unit(random) - 0.5);
      double b = 2 * kPi * (j + 0.4 * unit(random)) / sectors;
      if (j > 0 && unit(random) < 0.2) b = 2 * kPi * (j - 1 + 0.41) / sectors + sliver * 0.1 * unit(random);
      const double r = i == 0 || i == rings ? 1e-3 : 1e-3 * (1 + roughness * (unit(random) - 0.5));
      place.push_back(r * dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  }
  // All directions of a ring must rise. Otherwise the ball intersects itself.
  for (int i = 1; i < rings; ++i) {
    const auto first = place.begin() + i * sectors;
    std::sort(first, first + sectors, [](const dvec3& p, const dvec3& q) {
      const auto angle = [](const dvec3& v) {
        return std::atan2(v.y, v.x) < 0 ? std::atan2(v.y, v.x) + 2 * kPi : std::atan2(v.y, v.x);
      };
      return angle(p) < angle(q);
    });
  }
  const auto at = [&](int i, int j) -> dvec3 {
    if (i == 0) return {0, 0, 1e-3};
    if (i == rings) return {0, 0, -1e-3};
    return place[static_cast<std::size_t>(i * sectors + j % sectors)];
  };
  TissueMesh soup;
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      if (i > 0) add(soup, at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + 1 < rings) add(soup, at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
    }
  }
  const std::size_t faces = soup.triangles.size();
  for (std::size_t k = 0; k < faces; ++k) {
    const glm::uvec3 t = soup.triangles[k];
    const dvec3 a = soup.vertices[t.x], b = soup.vertices[t.y], c = soup.vertices[t.z];
    if (unit(random) < 0.05) add(soup, a, b, c);                           // a copy
    if (unit(random) < 0.05) add(soup, a, b, a + unit(random) * (b - a));  // no area
  }
  TissueMesh mesh = unit(random) < 0.5 ? welded(soup) : soup;
  if (mesh.vertices.size() == soup.vertices.size()) {  // cracks
    for (dvec3& v : mesh.vertices) v += 2e-9 * (dvec3(unit(random), unit(random), unit(random)) - 0.5);
  }
  return mesh;
}

/// Returns true if the line segment from p to q crosses a face. Tests every face (Moeller & Trumbore 1997).
bool is_blocked(const TriangleGrid& grid, const dvec3& p, const dvec3& q) {
  const dvec3 way = q - p;
  for (std::uint32_t i = 0; i < grid.size(); ++i) {
    const Face& f = grid.face(i);
    const dvec3 e1 = f.b - f.a, e2 = f.c - f.a, h = glm::cross(way, e2);
    const double det = glm::dot(e1, h);
    if (!(std::abs(det) > 0)) continue;
    const dvec3 s = p - f.a, k = glm::cross(s, e1);
    const double u = glm::dot(s, h) / det, v = glm::dot(way, k) / det, at = glm::dot(e2, k) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && at >= 0 && at <= 1) return true;
  }
  return false;
}

double min_distance(const TriangleGrid& grid, const dvec3& p) {
  double least = 1e300;
  for (std::uint32_t i = 0; i < grid.size(); ++i)
    least = std::min(least, glm::distance(p, nearest_on(grid.face(i), p).p));
  return least;
}

// ./run stress 100 tests 100,000 meshes.
TEST(SurfacePoint, NeverPassesThroughADefectiveMesh) {
  std::mt19937 random(20090417);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int n = 0; n < test::campaign(1000); ++n) {
    const TriangleGrid grid(bad_ball(random));
    SurfacePoint p = point(unit(random) < 0.5 ? 0 : 0.2e-3 * unit(random));
    const auto direction = [&] {
      std::normal_distribution<double> normal;
      return glm::normalize(dvec3(normal(random), normal(random), normal(random)));
    };
    p.put(grid, 2e-3 * direction());
    dvec3 hand = p.place();
    for (int i = 0; i < 10; ++i) {
      // The hand slides below the surface, or jumps through the body.
      hand = unit(random) < 0.3 ? 1.5e-3 * direction() : hand + 0.2e-3 * direction();
      p.follow(grid, hand);
      ASSERT_GE(min_distance(grid, p.place()), p.radius() * (1 - 1e-3)) << "mesh " << n << " move " << i;
      // The ball is star-shaped about the origin: a line from the origin to a point outside crosses a face. The line
      // may pass through a crack, and copies of faces count twice in the winding number. But the two errors do not
      // occur together.
      bool outside = !grid.inside(p.place());
      for (int k = 0; k < 4; ++k)
        outside |= is_blocked(grid, 1e-6 * static_cast<double>(k) * dvec3(1, -1, 0.5), p.place());
      ASSERT_TRUE(outside) << "mesh " << n << " move " << i;
    }
  }
}

TEST(SurfacePoint, AgreesWithASearchOfAllFaces) {
  // The grid finds all relevant faces: a search over all faces gives the same nearest point.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int n = 0; n < test::campaign(1000); ++n) {
    const TriangleGrid grid(bad_ball(random));
    for (int i = 0; i < 10; ++i) {
      const dvec3 p = 1.5e-3 * dvec3(unit(random), unit(random), unit(random));
      ASSERT_EQ(grid.nearest(p, 5e-3).distance, min_distance(grid, p));
      const dvec3 q = 1.5e-3 * dvec3(unit(random), unit(random), unit(random));
      std::vector<int> seen(grid.size());
      grid.for_near(glm::min(p, q), glm::max(p, q), [&](std::uint32_t f) { ++seen[f]; });
      for (std::uint32_t f = 0; f < grid.size(); ++f) {
        const Face& face = grid.face(f);
        const dvec3 lo = glm::min(face.a, glm::min(face.b, face.c)), hi = glm::max(face.a, glm::max(face.b, face.c));
        const bool meets =
            glm::all(glm::lessThanEqual(lo, glm::max(p, q))) && glm::all(glm::greaterThanEqual(hi, glm::min(p, q)));
        ASSERT_LE(seen[f], 1);
        ASSERT_TRUE(!meets || seen[f] == 1);
      }
    }
  }
}

TEST(SurfacePoint, TheEngagedAreaOfABallThatSinksIntoACreaseIsThatOfASearchOfTheGrid) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  TissueMesh soup;
  add_sheet(soup, {0, 0, 0}, {2e-3, 0, 0}, {0, 2e-3, 0}, 40, Tissue::kEnamel);
  add_sheet(soup, {0, 0, 0}, {0, 2e-3, 0}, {0, 0, 2e-3}, 40, Tissue::kDentin);
  TissueMesh mesh = welded(soup);
  for (dvec3& p : mesh.vertices) p += 1e-5 * dvec3(unit(random), unit(random), unit(random));
  const TriangleGrid grid(mesh, true);
  SurfacePoint ball = point(0.6e-3);
  ball.put_free({0.65e-3, 1e-3, 0.65e-3});
  int compared = 0;
  for (int i = 0; i < 200; ++i) {
    ball.follow(grid, {0.5e-3, 1e-3 + 1e-6 * i, 0.5e-3}, true);
    SurfacePoint fresh = point(0.6e-3);
    fresh.put_free(ball.place());
    const dvec3 way = glm::normalize(dvec3(-1, 0.1, -1));
    const PerTissue area = ball.engaged_area(grid, way), expected = fresh.engaged_area(grid, way);
    for (std::size_t t = 0; t < area.size(); ++t) ASSERT_NEAR(area[t], expected[t], 1e-12 * expected[t]);
    compared +=
        area[static_cast<std::size_t>(Tissue::kEnamel)] > 0 && area[static_cast<std::size_t>(Tissue::kDentin)] > 0;
    ball.sink_to(ball.place() + 2e-7 * way);
  }
  EXPECT_GT(compared, 100);
}

TEST(SurfacePoint, ASearchThatIsDividedBetweenTicksEndsAtRestAndOutsideTheMesh) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  TissueMesh soup;
  add_sheet(soup, {-2e-3, -2e-3, 0}, {4e-3, 0, 0}, {0, 4e-3, 0}, 90);
  TissueMesh mesh = welded(soup);
  for (dvec3& p : mesh.vertices) p.z += 0.3e-3 * std::sin(3e3 * p.x) * std::cos(2e3 * p.y) + 4e-6 * unit(random);
  const TriangleGrid grid(mesh);
  int later = 0;
  for (int n = 0; n < 60; ++n) {
    // The large ball touches so many faces that the search takes several calls.
    const double radius = n % 2 == 0 ? 0.9e-3 : 0.1e-3;
    SurfacePoint ball = point(radius);
    dvec3 hip(0.5e-3 * unit(random), 0.5e-3 * unit(random), radius + 0.5e-3);
    ball.put(grid, hip);
    for (int move = 0; move < 8; ++move) {
      hip += 0.3e-3 * dvec3(unit(random), unit(random), move == 0 ? -2 : 0.3 * unit(random));
      ball.follow(grid, hip);
      const dvec3 first = ball.place();
      for (int k = 0; k < 60; ++k) ball.follow(grid, hip);
      const dvec3 last = ball.place();
      later += glm::distance(first, last) > 1e-9;
      ball.follow(grid, hip);
      ASSERT_LT(glm::distance(ball.place(), last), 1e-10) << n << " " << move;
      ASSERT_GT(grid.nearest(last, 2 * radius).distance, radius - 1e-9) << n << " " << move;
    }
  }
  EXPECT_GT(later, 10) << "searches were divided";
}

TEST(SurfacePoint, InsideIsDecidedByTheWindingNumber) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int n = 0; n < 100; ++n) {
    TissueMesh soup;
    const double h = 1e-3;
    add_sheet(soup, {-h, -h, h}, {2 * h, 0, 0}, {0, 2 * h, 0}, 2);
    add_sheet(soup, {-h, -h, -h}, {0, 2 * h, 0}, {2 * h, 0, 0}, 2);
    add_sheet(soup, {h, -h, -h}, {0, 2 * h, 0}, {0, 0, 2 * h}, 2);
    add_sheet(soup, {-h, -h, -h}, {0, 0, 2 * h}, {0, 2 * h, 0}, 2);
    add_sheet(soup, {-h, h, -h}, {0, 0, 2 * h}, {2 * h, 0, 0}, 2);
    add_sheet(soup, {-h, -h, -h}, {2 * h, 0, 0}, {0, 0, 2 * h}, 2);
    const TriangleGrid grid(welded(soup));
    EXPECT_EQ(grid.winding_sixths(dvec3(0)), 6);  // on edges of the sheets in every direction
    const dvec3 p = 2e-3 * dvec3(unit(random), unit(random), unit(random));
    const bool inside = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < h;
    EXPECT_EQ(grid.winding_sixths(p), inside ? 6 : 0);
  }
}

// --- Levels

const TissueMesh& arch() {
  static const TissueMesh mesh = read_tissue_mesh("assets/jaw/lower_arch.ply", 1e-3, Tissue::kEnamel).mesh;
  return mesh;
}
/// Returns the paper's levels for the shipped dental arch.
const Levels& paper_levels() {
  static const auto levels = make_levels(arch(), {143865, {33140, 13306, 7443}});
  return *levels;
}

TEST(MeshLevels, OfTheArchHaveTheVertexCountsOfThePaper) {
  const Levels& levels = paper_levels();
  ASSERT_EQ(levels.vertices.size(), 3U);
  const double wanted[] = {33140, 13306, 7443};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(static_cast<double>(levels.vertices[i]), wanted[i], 0.01 * wanted[i]);
  EXPECT_NEAR(static_cast<double>(vertex_count(base_mesh(arch(), {143865, {}}))), 143865, 1438);
  for (const TriangleGrid& level : levels.grids) EXPECT_LT(hausdorff_distance(levels.grids[0], level), 0.5e-3);
}

TEST(MeshLevels, KeepOpenBordersAndTissueBorders) {
  const TissueMesh coarse = simplified(arch(), 3000);
  const auto border_length = [](const TissueMesh& mesh) {
    std::map<std::pair<unsigned, unsigned>, int> edges;
    for (const glm::uvec3& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    double length = 0;
    for (const auto& [e, times] : edges)
      if (times == 1) length += glm::distance(mesh.vertices[e.first], mesh.vertices[e.second]);
    return length;
  };
  EXPECT_NEAR(border_length(coarse) / border_length(arch()), 1, 1e-9);

  // A flat sheet consists of two tissues with a straight border between them.
  TissueMesh soup;
  add_sheet(soup, {0, 0, 0}, {5e-3, 0, 0}, {0, 10e-3, 0}, 24, Tissue::kEnamel);
  add_sheet(soup, {-5e-3, 0, 0}, {5e-3, 0, 0}, {0, 10e-3, 0}, 24, Tissue::kDentin);
  const TissueMesh two = simplified(welded(soup), 100);
  EXPECT_LT(two.triangles.size(), 400U);
  for (std::size_t i = 0; i < two.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double x = two.vertices[two.triangles[i][k]].x;
      EXPECT_TRUE(two.tissue[i] == Tissue::kEnamel ? x >= 0 : x <= 0);
    }
  }
}

TEST(MeshLevels, SubdivisionDoesNotMoveTheSurface) {
  const TissueMesh fine = subdivided(arch());
  EXPECT_EQ(vertex_count(fine), 13288U + 39778U);
  EXPECT_EQ(fine.triangles.size(), 4 * arch().triangles.size());
  const TriangleGrid coarse_grid(arch());
  for (std::size_t i = 0; i < fine.vertices.size(); i += 7)
    EXPECT_LT(coarse_grid.nearest(fine.vertices[i], 1e-3).distance, 1e-12);
}

TEST(LevelBySpeed, SwitchesTwiceACycleIfTheSpeedOscillatesAboutALimit) {
  LevelBySpeed level({30e-3, 120e-3}, 0.1);
  int switches = 0;
  std::size_t last = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double speed = 30e-3 + 15e-3 * std::sin(2 * kPi * i / 1000.0);
    const std::size_t now = level.step(speed * 1e-3, 1e-3, 3);
    if (i > 0) switches += now != last;
    last = now;
  }
  EXPECT_LE(switches, 20);
  EXPECT_GE(switches, 18);
}

TEST(LevelBySpeed, SwitchesDirectlyToTheLevelOfTheSpeed) {
  LevelBySpeed level({30e-3, 120e-3}, 0.1);
  EXPECT_EQ(level.step(200e-6, 1e-3, 3), 2U);
  level.reset();
  EXPECT_EQ(level.step(60e-6, 1e-3, 3), 1U);
  level.reset();
  EXPECT_EQ(level.step(10e-6, 1e-3, 3), 0U);
  level.reset();
  EXPECT_EQ(level.step(200e-6, 1e-3, 1), 0U);  // there is only one level
}

}  // namespace
}  // namespace typodont::haptics::mesh_lod
