// Benchmark of the surface mesher for `typodont bench`: running time and accuracy.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "engine/surface/mesh_export.h"

namespace typodont::surface {

struct BenchOptions {
  int repeats = 9;
  // voxels, tolerances of the measured meshes; negative: full resolution
  std::vector<double> tolerances = {-1, 0, 0.05, 0.1, 0.2};
  // s, reference time to mesh a changed block of 32³ samples, assumed as lower limit (5 to 8 µs were measured)
  double floor_32 = 6.5e-6;
};

/// Meshes a sphere with a radius R of 50 voxels. `error` is N·ε/R with the number N of triangles and the largest error
/// ε. The time is that of a brick of 16³ cells, so its baseline is floor_32 / 8 (floor_32 is for 32³ samples).
std::vector<BenchRow> bench_sphere(const BenchOptions& options);

/// Returns the largest |distance| over a fine grid of points on every triangle.
double largest_error(const WholeMesh& mesh, const std::function<double(const glm::dvec3&)>& distance);

}  // namespace typodont::surface
