// Tests of properties that the mesh of any field must have, and of its distance from surfaces with known formulas.
#include <gtest/gtest.h>

#include <random>

#include "engine/base/voxels.h"
#include "engine/surface/mesh_export.h"
#include "tests/support/surface_checks.h"

namespace typodont::surface {
namespace {

using test::Field;
using test::max_error;
using test::mesh_of;
using test::sample_bricks;
using test::Topology;
using test::topology_of;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  glm::dvec3 point(double low, double high) { return {uniform(low, high), uniform(low, high), uniform(low, high)}; }
  double normal() { return std::normal_distribution<double>()(engine_); }
  glm::dvec3 direction() { return glm::normalize(glm::dvec3(normal(), normal(), normal())); }

 private:
  std::mt19937 engine_;
};

void expect_surface(const Topology& t, long euler, int components = 1) {
  EXPECT_TRUE(t.closed && t.oriented && t.manifold) << t.complaint;
  EXPECT_EQ(t.euler, euler);
  EXPECT_EQ(t.components, components);
  EXPECT_GT(t.volume, 0);
}

TEST(Sphere, NeedsFewTrianglesForItsErrorAndStaysWithinTheTolerance) {
  // With N triangles of deviation ε on a sphere of radius R, the best possible value of N·ε/R is 4.84 for inscribed
  // triangles. Marching cubes gives 14.1.
  Random random(4);
  for (const double radius : {7.5, 12.0, 20.0, 33.0}) {
    for (const float tolerance : {-1.f, 0.02f, 0.05f, 0.1f, 0.25f}) {
      const glm::dvec3 centre = random.point(0, 16);
      const Field sphere = [=](const glm::dvec3& p) { return glm::length(p - centre) - radius; };
      const auto bricks = sample_bricks(centre - radius - 2.0, centre + radius + 2.0, sphere);
      const WholeMesh mesh = weld(mesh_of(bricks, tolerance));
      const double error = max_error(mesh, sphere);
      SCOPED_TRACE("radius " + std::to_string(radius) + ", tolerance " + std::to_string(tolerance));
      expect_surface(topology_of(mesh), 2);
      EXPECT_LT(static_cast<double>(mesh.triangles.size()) * error / radius, 7.3);
      EXPECT_LT(error, std::max(static_cast<double>(tolerance), 0.16 / radius));  // at least as good as full resolution
    }
  }
}

TEST(Box, HasExactFacesAndCornersAtAnyOffset) {
  Random random(7);
  for (int i = 0; i < 24; ++i) {
    const glm::dvec3 centre = random.point(0, 16), half = random.point(6, 13);
    const bool true_distance = i % 2;
    const Field box = [=](const glm::dvec3& p) {
      const glm::dvec3 d = glm::abs(p - centre) - half;
      const double inside = std::max({d.x, d.y, d.z});
      return true_distance ? glm::length(glm::max(d, 0.0)) + std::min(inside, 0.0) : inside;
    };
    const auto bricks = sample_bricks(centre - half - 2.0, centre + half + 2.0, box);
    for (const float tolerance : {-1.f, 0.1f}) {
      const WholeMesh mesh = weld(mesh_of(bricks, tolerance));
      expect_surface(topology_of(mesh), 2);
      EXPECT_LT(max_error(mesh, box, 2), 2e-4) << i;
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at = centre + half * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        double nearest = 1e9;
        for (const auto& v : mesh.vertices) nearest = std::min(nearest, glm::length(glm::dvec3(v.position) - at));
        EXPECT_LT(nearest, 1e-3) << i;
      }
      if (tolerance > 0) {
        EXPECT_LT(mesh.triangles.size(), 200u);
      }
    }
  }
}

TEST(Box, TurnedAnyWayKeepsItsEdgesAndFourInFiveCorners) {
  // A corner of the solid that projects between the edges of the lattice crosses no edge, so the mesh cannot show it.
  Random random(11);
  int kept = 0;
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 centre = random.point(0, 16), half = random.point(7, 12);
    const glm::dvec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction()));
    const glm::dmat3 turn(x, y, glm::cross(x, y));
    const Field box = [=](const glm::dvec3& p) {
      const glm::dvec3 d = glm::abs((p - centre) * turn) - half;
      return std::max({d.x, d.y, d.z});
    };
    const WholeMesh mesh = weld(mesh_of(sample_bricks(centre - 24.0, centre + 24.0, box), 0.05f));
    expect_surface(topology_of(mesh), 2);
    EXPECT_LT(max_error(mesh, box, 3), 0.35);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 at =
          centre + turn * (half * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1));
      double nearest = 1e9;
      for (const auto& v : mesh.vertices) nearest = std::min(nearest, glm::length(glm::dvec3(v.position) - at));
      EXPECT_LT(nearest, 0.5) << "box " << i << ", corner " << corner;
      kept += nearest < 0.1;
    }
  }
  EXPECT_GE(kept, 12 * 8 * 4 / 5);
}

TEST(Colors, RefineAFlatFaceOnlyWhereTheyChangeAndMoveNoVertexOffIt) {
  const glm::dvec3 half(40, 40, 8);
  const Field box = [=](const glm::dvec3& p) {
    const glm::dvec3 d = glm::abs(p - 40.0) - half;
    return std::max({d.x, d.y, d.z});
  };
  auto bricks = sample_bricks(glm::dvec3(-2), glm::dvec3(82), box);
  const std::size_t plain = weld(mesh_of(bricks, 0.1f)).triangles.size();
  // Colours that a function of x gives to every sample.
  const auto triangles = [&](const auto& color_at) {
    for (FieldBrick& brick : bricks) {
      brick.colored = true;
      for_each_voxel(glm::ivec3(FieldBrick::kSamples), [&](int x, int y, int z) {
        brick.color[FieldBrick::at(x, y, z)] = color_at(FieldBrick::kCells * brick.key.x - 1 + x);
      });
    }
    const WholeMesh mesh = weld(mesh_of(bricks, 0.1f));
    expect_surface(topology_of(mesh), 2);
    EXPECT_LT(max_error(mesh, box, 2), 2e-4);
    return mesh.triangles.size();
  };
  EXPECT_EQ(triangles([](int) { return VoxelColor{0x8410}; }), plain);
  const auto step = triangles([](int x) { return x < 37 ? VoxelColor{0x8410} : kTissueColor; });
  const auto all = triangles([](int x) { return voxel_color(glm::dvec3(x % 2)); });
  EXPECT_GT(step, plain + 2 * 80) << "two cells beside each other along the border";
  EXPECT_LT(step, all / 8) << "and not elsewhere";
}

TEST(Plate, WithADrilledHoleHasGenusOneAndASharpRim) {
  Random random(5);
  for (const float tolerance : {-1.f, 0.05f, 0.2f}) {
    const glm::dvec3 centre = random.point(0, 16);
    const Field plate = [=](const glm::dvec3& p) {
      const glm::dvec3 d = glm::abs(p - centre) - glm::dvec3(20, 18, 4.3);
      return std::max({d.x, d.y, d.z, 6.4 - std::hypot(p.x - centre.x, p.y - centre.y)});
    };
    const WholeMesh mesh = weld(mesh_of(sample_bricks(centre - 23.0, centre + 23.0, plate), tolerance));
    expect_surface(topology_of(mesh), 0);
    EXPECT_LT(max_error(mesh, plate), 0.25);  // at the rim; elsewhere the error is within the tolerance:
    double away = 0;
    for (const auto& v : mesh.vertices) {
      const glm::dvec3 p = v.position;
      const double wall = std::hypot(p.x - centre.x, p.y - centre.y) - 6.4, face = 4.3 - std::abs(p.z - centre.z);
      if (std::abs(wall) > 2 || face > 2) away = std::max(away, std::abs(plate(p)));
    }
    EXPECT_LT(away, std::max(static_cast<double>(tolerance), 0.03));
  }
}

TEST(AnyField, GivesAClosedManifold) {
  // White noise contains every configuration of signs in every neighbourhood. Blended with a ball, it contains every
  // transition between merged and full-resolution cells.
  for (unsigned seed = 0; seed < 9; ++seed) {
    Random random(seed);
    const int n = 32;
    std::vector<double> noise(static_cast<std::size_t>(n * n * n));
    for (double& v : noise) v = random.normal();
    const double fraction = seed % 3 == 0 ? 1 : seed % 3 == 1 ? 0.12 : 0.4;
    const Field field = [&](const glm::dvec3& p) {
      const glm::ivec3 q(p);
      const bool margin = q.x < 2 || q.y < 2 || q.z < 2 || q.x >= n - 2 || q.y >= n - 2 || q.z >= n - 2;
      if (margin) return 1.0;
      const double ball = fraction == 1 ? 0 : glm::length(p - 16.0) - 11;
      return ball + 4 * fraction * noise[static_cast<std::size_t>((q.x * n + q.y) * n + q.z)];
    };
    const auto bricks = sample_bricks(glm::dvec3(0), glm::dvec3(n), field);
    for (const float tolerance : {-1.f, 0.3f, 3.f}) {
      const Topology t = topology_of(weld(mesh_of(bricks, tolerance)));
      EXPECT_TRUE(t.closed && t.oriented && t.manifold) << "seed " << seed << ": " << t.complaint;
    }
  }
}

TEST(Normals, PointOutAlongTheGradient) {
  const glm::dvec3 centre(9.3, 8.1, 7.7);
  const Field sphere = [=](const glm::dvec3& p) { return glm::length(p - centre) - 11; };
  for (const auto& v : weld(mesh_of(sample_bricks(glm::dvec3(-5), glm::dvec3(22), sphere), 0.05f)).vertices) {
    EXPECT_GT(glm::dot(glm::dvec3(v.normal), glm::normalize(glm::dvec3(v.position) - centre)), 0.998);
  }
}

TEST(Normals, OnACreaseEachSideHasItsOwnNormals) {
  const Field box = [](const glm::dvec3& p) {
    const glm::dvec3 d = glm::abs(p - 8.2) - glm::dvec3(6.1, 5.2, 4.4);
    return std::max({d.x, d.y, d.z});
  };
  const SurfaceMesher mesher = mesh_of(sample_bricks(glm::dvec3(0), glm::dvec3(16), box), 0.05f);
  int corners = 0;
  for (const glm::ivec3& key : mesher.keys()) {
    const BrickMesh& mesh = *mesher.find(key);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const SurfaceVertex* v[3];
      for (std::size_t k = 0; k < 3; ++k) v[k] = &mesh.vertices[mesh.indices[i + k]];
      const glm::vec3 n = glm::cross(v[1]->position - v[0]->position, v[2]->position - v[0]->position);
      if (glm::length(n) < 1e-3f) continue;
      for (const SurfaceVertex* corner : v) {
        EXPECT_GT(glm::dot(corner->normal, glm::normalize(n)), 0.99f);
        ++corners;
      }
    }
  }
  EXPECT_GE(corners, 36);
}

TEST(Normals, AGentleCreaseIsShadedSmoothAndAnAcuteOneSharp) {
  // A furrow between two planes that is oblique to the lattice, at full resolution. The test measures how much normals
  // at one position differ.
  const glm::dvec3 along = glm::normalize(glm::dvec3(1, 0.31, 0.17)),
                   up = glm::normalize(glm::cross(along, glm::dvec3(-0.2, 1, 0)));
  const glm::dvec3 across = glm::cross(up, along);
  const auto worst = [&](double degrees) {  // angle between the normals of the two sides
    const double half = glm::radians(degrees / 2);
    const Field furrow = [&](const glm::dvec3& p) {
      const glm::dvec3 q = p - glm::dvec3(8.3, 7.9, 8.1);
      const double x = glm::dot(q, across), z = glm::dot(q, up);
      return std::max({std::min(z * std::cos(half) - x * std::sin(half), z * std::cos(half) + x * std::sin(half)),
                       glm::length(q) - 12});
    };
    const SurfaceMesher mesher = mesh_of(sample_bricks(glm::dvec3(-6), glm::dvec3(22), furrow), 0);
    float least = 1;
    for (const glm::ivec3& key : mesher.keys()) {
      const BrickMesh& mesh = *mesher.find(key);
      for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        if (glm::length(glm::dvec3(mesh.vertices[i].position) - glm::dvec3(8.3, 7.9, 8.1)) > 9)
          continue;  // this is not the ball's rim
        for (std::size_t j = 0; j < i; ++j) {
          if (mesh.vertices[i].position != mesh.vertices[j].position) continue;
          least = std::min(least, glm::dot(mesh.vertices[i].normal, mesh.vertices[j].normal));
        }
      }
    }
    return glm::degrees(std::acos(std::clamp(least, -1.f, 1.f)));
  };
  EXPECT_LT(worst(35), 0.1);
  EXPECT_LT(worst(50), 0.1);
  EXPECT_NEAR(worst(90), 90, 5);
}

TEST(Tissues, BoundaryIsDrawnWhereItRuns) {
  // A ball with enamel above an oblique plane and dentin below it. The line where `second` equals one half must follow
  // the plane.
  const glm::dvec3 centre(24.4, 23.8, 24.1), up = glm::normalize(glm::dvec3(0.3, 0.2, 1));
  const Field sphere = [=](const glm::dvec3& p) { return glm::length(p - centre) - 18; };
  const auto labels = [=](const glm::dvec3& p) {
    return glm::dot(p - centre, up) < 3 ? Tissue::kDentin : Tissue::kEnamel;
  };
  const SurfaceMesher mesher = mesh_of(sample_bricks(glm::dvec3(0), glm::dvec3(48), sphere, labels), 0.2f);
  int crossings = 0;
  double sum = 0;
  for (const glm::ivec3& key : mesher.keys()) {
    const BrickMesh& mesh = *mesher.find(key);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      for (std::size_t k = 0; k < 3; ++k) {
        const SurfaceVertex &a = mesh.vertices[mesh.indices[i + k]], &b = mesh.vertices[mesh.indices[i + (k + 1) % 3]];
        ASSERT_EQ(a.tissue[0], b.tissue[0]);
        ASSERT_EQ(a.tissue[1], b.tissue[1]);
        // Every point of the mesh is drawn in its own tissue, except within a voxel of the boundary.
        const double height = glm::dot(glm::dvec3(a.position) - centre, up) - 3;
        const Tissue drawn = a.tissue[a.second > 127];
        if (std::abs(height) > 1) {
          EXPECT_EQ(drawn, height < 0 ? Tissue::kDentin : Tissue::kEnamel) << height;
        }
        if ((a.second > 127) == (b.second > 127)) continue;
        const double s = (127.5 - a.second) / (static_cast<double>(b.second) - a.second);
        const glm::dvec3 p = glm::mix(glm::dvec3(a.position), glm::dvec3(b.position), s);
        const double off = glm::dot(p - centre, up) - 3;
        EXPECT_LT(std::abs(off), 0.8);
        sum += off * off;
        ++crossings;
      }
    }
  }
  ASSERT_GT(crossings, 100);
  // labels belong to whole voxels: rounding has a standard deviation of 0.29
  EXPECT_LT(std::sqrt(sum / crossings), 0.35);
}

}  // namespace
}  // namespace typodont::surface
