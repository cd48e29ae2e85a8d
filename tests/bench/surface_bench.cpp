// Prints the rows beside OpenVDB's volumeToMesh; checks only ratios of medians, with room.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "engine/base/clock.h"
#include "engine/surface/bench.h"
#include "engine/surface/mesh_export.h"
#include "engine/surface/surface_mesher.h"
#include "tests/support/surface_checks.h"

namespace typodont::surface {
namespace {

using openvdb::FloatGrid;

struct Vdb {
  double seconds = 0;  // median, one thread
  std::size_t triangles = 0;
  double error = 0;  // voxels
};

Vdb volume_to_mesh(const FloatGrid& grid, int repeats, const test::Field& distance = {}) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<double> times;
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  for (int i = 0; i < repeats; ++i) {
    const Nanos start = thread_cpu_time();
    openvdb::tools::volumeToMesh(grid, points, triangles, quads, 0.0, 0.0);
    times.push_back(to_seconds(thread_cpu_time() - start));
  }
  std::sort(times.begin(), times.end());
  Vdb out{times[times.size() / 2], triangles.size() + 2 * quads.size(), 0};
  if (distance) {
    WholeMesh mesh;
    for (const auto& p : points) {
      const openvdb::Vec3d q = grid.worldToIndex(p);
      mesh.vertices.push_back({glm::vec3(q.x(), q.y(), q.z()), {}, Tissue::kEnamel});
    }
    for (const auto& q : quads) {
      mesh.triangles.push_back({q[0], q[1], q[2]});
      mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    out.error = test::greatest_error(mesh, distance);
  }
  return out;
}

// The shipped molar at 0.05 mm; distances in voxels.
FloatGrid::Ptr molar(double voxel_mm) {
  openvdb::initialize();
  openvdb::io::File file("assets/teeth/molar.vdb");
  file.open(false);
  const auto coarse = openvdb::gridPtrCast<FloatGrid>(file.readGrid("distance"));
  auto fine = FloatGrid::create(coarse->background());
  fine->setTransform(openvdb::math::Transform::createLinearTransform(voxel_mm));
  openvdb::tools::resampleToMatch<openvdb::tools::QuadraticSampler>(*coarse, *fine);
  const auto scale = static_cast<float>(1 / voxel_mm);
  const float band = 4;
  auto grid = FloatGrid::create(band);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto out = grid->getAccessor();
  for (auto it = fine->cbeginValueOn(); it; ++it) {
    const float d = *it * scale;
    if (std::abs(d) < band) out.setValue(it.getCoord(), d);
  }
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

std::vector<FieldBrick> bricks_of(const FloatGrid& grid) {
  std::vector<FieldBrick> bricks;
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  const auto in = grid.getConstAccessor();
  FieldBrick brick;
  brick.tissue.fill(Tissue::kEnamel);
  auto floor16 = [](int v) { return static_cast<int>(std::floor(v / 16.0)); };
  for (int x = floor16(box.min().x()); x <= floor16(box.max().x()); ++x) {
    for (int y = floor16(box.min().y()); y <= floor16(box.max().y()); ++y) {
      for (int z = floor16(box.min().z()); z <= floor16(box.max().z()); ++z) {
        brick.key = {x, y, z};
        for (int i = 0; i < FieldBrick::kSamples; ++i) {
          for (int j = 0; j < FieldBrick::kSamples; ++j) {
            for (int k = 0; k < FieldBrick::kSamples; ++k) {
              brick.distance[FieldBrick::at(i, j, k)] = in.getValue({16 * x - 1 + i, 16 * y - 1 + j, 16 * z - 1 + k});
            }
          }
        }
        if (test::has_surface(brick)) bricks.push_back(brick);
      }
    }
  }
  return bricks;
}

// The bricks whose samples a ball changes, after it was cut away.
std::vector<FieldBrick> cut(const std::vector<FieldBrick>& whole, const glm::dvec3& centre, double radius) {
  std::vector<FieldBrick> changed;
  for (FieldBrick brick : whole) {
    bool any = false;
    for (int i = 0; i < FieldBrick::kSamples; ++i) {
      for (int j = 0; j < FieldBrick::kSamples; ++j) {
        for (int k = 0; k < FieldBrick::kSamples; ++k) {
          const glm::dvec3 p(16 * brick.key - 1 + glm::ivec3(i, j, k));
          float& value = brick.distance[FieldBrick::at(i, j, k)];
          const auto depth = static_cast<float>(std::min(radius - glm::length(p - centre), 4.0));
          if (depth > value) {
            value = depth;
            any = true;
          }
        }
      }
    }
    if (any) changed.push_back(brick);
  }
  return changed;
}

void print(const std::vector<BenchRow>& rows) {
  for (const auto& r : rows) {
    fmt::print("{:<18}{:<18}{:>9.3g} {:<40}{:>10.4g} ms per {:<13}{:>9.0f} triangles  ratio {:.4f} of {}\n", r.name,
               r.knob, r.error, r.error_unit, r.time_ns * 1e-6, r.per, r.size, r.ratio, r.baseline);
  }
}

TEST(SurfaceBench, SphereNeedsFewTrianglesForItsError) {
  const std::vector<BenchRow> rows = bench_sphere({});
  print(rows);
  for (const BenchRow& row : rows) EXPECT_LT(row.error, 7.3) << row.knob;
}

TEST(SurfaceBench, DrillingFrameOnTheMolarIsFiftyTimesFasterThanMeshingItWhole) {
  const FloatGrid::Ptr grid = molar(0.05);
  const std::vector<FieldBrick> whole = bricks_of(*grid);
  ASSERT_GT(whole.size(), 1000u);
  // A ball of 1.2 mm, half sunk into the surface, moves on by a sixtieth of a second.
  const glm::dvec3 centre = 16.0 * glm::dvec3(whole[whole.size() / 2].key) + 8.0;
  const std::vector<FieldBrick> drilled = cut(whole, centre, 12);
  ASSERT_GT(drilled.size(), 4u);
  const Vdb baseline = volume_to_mesh(*grid, 5);
  fmt::print("volumeToMesh, one thread: {:.1f} ms, {} triangles; {} bricks, {} of them drilled\n",
             baseline.seconds * 1e3, baseline.triangles, whole.size(), drilled.size());
  const std::vector<BenchRow> rows = bench_tissue(whole, drilled, baseline.seconds, {.repeats = 5});
  print(rows);
  for (const BenchRow& row : rows) {
    if (row.name == "drilling frame") {
      EXPECT_LT(row.ratio, 1.0 / 50) << row.knob;
    } else {
      EXPECT_LT(row.ratio, 1) << row.knob;
    }
  }
}

TEST(SurfaceBench, WholeExtractionIsThreeTimesFasterAtEqualError) {
  // One ball, sampled coarsely for ours and finer for volumeToMesh until its mesh is as true.
  auto sphere = [](double radius) {
    return [radius](const glm::dvec3& p) { return glm::length(p - glm::dvec3(8.3, 7.6, 8.9)) - radius; };
  };
  const double ours_radius = 60;
  const auto bricks = bench_bricks(glm::dvec3(-60), glm::dvec3(76), sphere(ours_radius));
  std::vector<double> times;
  WholeMesh mesh;
  for (int i = 0; i < 5; ++i) {
    const Nanos start = thread_cpu_time();
    SurfaceMesher mesher({.tolerance = -1});
    for (const FieldBrick& brick : bricks) mesher.put(brick);
    mesher.remesh();
    times.push_back(to_seconds(thread_cpu_time() - start));
    if (i == 0) mesh = weld(mesher);
  }
  std::sort(times.begin(), times.end());
  const double ours = test::greatest_error(mesh, sphere(ours_radius)) / ours_radius;

  openvdb::initialize();
  for (double radius = ours_radius;; radius *= 1.1) {
    ASSERT_LT(radius, 400);
    auto grid = FloatGrid::create(4);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    auto out = grid->getAccessor();
    const auto distance = sphere(radius);
    const int reach = static_cast<int>(radius) + 15;
    for (int x = -reach; x <= reach; ++x) {
      for (int y = -reach; y <= reach; ++y) {
        for (int z = -reach; z <= reach; ++z) {
          const double d = distance({x, y, z});
          if (std::abs(d) < 3) out.setValue({x, y, z}, static_cast<float>(d));
        }
      }
    }
    openvdb::tools::signedFloodFill(grid->tree());
    const Vdb theirs = volume_to_mesh(*grid, 3, distance);
    fmt::print(
        "ball: ours radius {} voxels, error/radius {:.2e}, {:.1f} ms; volumeToMesh radius {:.0f}, {:.2e}, {:.1f} ms\n",
        ours_radius, ours, times[2] * 1e3, radius, theirs.error / radius, theirs.seconds * 1e3);
    if (theirs.error / radius > ours) continue;
    EXPECT_LT(3 * times[2], theirs.seconds);
    break;
  }
}

}  // namespace
}  // namespace typodont::surface
