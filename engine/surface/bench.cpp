#include "engine/surface/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/measure.h"
#include "engine/contract/field_brick.h"
#include "engine/surface/surface_mesher.h"

namespace typodont::surface {
namespace {

std::string knob(double tolerance) {
  return tolerance < 0 ? "full resolution" : fmt::format("tolerance {:g}", tolerance);
}

/// Bricks (16³ cells) with surface within [low, high], of a formula in voxels.
std::vector<FieldBrick> bricks_of(const glm::dvec3& low, const glm::dvec3& high,
                                  const std::function<double(const glm::dvec3&)>& distance) {
  std::vector<FieldBrick> bricks;
  const glm::ivec3 first(glm::floor(low / 16.0)), last(glm::floor(high / 16.0));
  FieldBrick brick;
  brick.tissue.fill(Tissue::kEnamel);
  for (int x = first.x; x <= last.x; ++x) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int z = first.z; z <= last.z; ++z) {
        brick.key = {x, y, z};
        bool solid = false, air = false;
        for (int i = 0; i < FieldBrick::kSamples; ++i) {
          for (int j = 0; j < FieldBrick::kSamples; ++j) {
            for (int k = 0; k < FieldBrick::kSamples; ++k) {
              const double d = distance(glm::dvec3(16 * brick.key - 1 + glm::ivec3(i, j, k)));
              brick.distance[FieldBrick::at(i, j, k)] = static_cast<float>(std::clamp(d, -4.0, 4.0));
              (d < 0 ? solid : air) = true;
            }
          }
        }
        if (solid && air) bricks.push_back(brick);
      }
    }
  }
  return bricks;
}

}  // namespace

double largest_error(const WholeMesh& mesh, const std::function<double(const glm::dvec3&)>& distance) {
  constexpr int n = 6;
  double worst = 0;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 a = mesh.vertices[t[0]].position, b = mesh.vertices[t[1]].position,
                     c = mesh.vertices[t[2]].position;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const glm::dvec3 p =
            (static_cast<double>(i) * a + static_cast<double>(j) * b + static_cast<double>(n - i - j) * c) /
            static_cast<double>(n);
        worst = std::max(worst, std::abs(distance(p)));
      }
    }
  }
  return worst;
}

std::vector<BenchRow> bench_sphere(const BenchOptions& options) {
  const double radius = 50;
  const glm::dvec3 centre(8.3, 7.6, 8.9);
  const auto sphere = [=](const glm::dvec3& p) { return glm::length(p - centre) - radius; };
  const std::vector<FieldBrick> bricks = bricks_of(centre - radius - 2.0, centre + radius + 2.0, sphere);
  std::vector<BenchRow> rows;
  for (const double tolerance : options.tolerances) {
    SurfaceMesher mesher({.tolerance = static_cast<float>(tolerance)});
    const double time = measure(options.repeats, [&] {
                          for (const FieldBrick& brick : bricks) mesher.put(brick);
                          mesher.remesh();
                        }).median;
    const WholeMesh mesh = weld(mesher);
    const auto triangles = static_cast<double>(mesh.triangles.size());
    BenchRow row;
    row.name = "sphere";
    row.knob = knob(tolerance);
    row.error = triangles * largest_error(mesh, sphere) / radius;
    row.error_unit = "N·ε/R (optimum 4.84, marching cubes 14.1)";
    row.time_ns = time / static_cast<double>(bricks.size());
    row.per = "brick of 16³";
    row.baseline = "floor of a 32³ block, an eighth";
    row.ratio = row.time_ns / (options.floor_32 * 1e9 / 8);
    row.size = triangles;
    row.size_unit = "triangles";
    rows.push_back(row);
  }
  return rows;
}

}  // namespace typodont::surface
