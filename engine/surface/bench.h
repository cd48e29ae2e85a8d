// Time and accuracy of the mesher, for `typodont bench`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "engine/surface/mesh_export.h"

namespace typodont::surface {

struct BenchOptions {
  int repeats = 9;
  // voxels; negative: cells are not merged
  std::vector<double> tolerances = {-1, 0, 0.05, 0.1, 0.2};
  // s, shortest time for a changed block of 32³ samples (5 to 8 µs measured), for comparison
  double floor_32 = 6.5e-6;
};

/// A sphere of R = 50 voxels per tolerance. `error`: N·ε/R (N triangles, largest distance ε). Time per brick of 16³
/// cells against floor_32 / 8.
std::vector<BenchRow> bench_sphere(const BenchOptions& options);

/// Over a fine grid of points on every triangle.
double largest_error(const WholeMesh& mesh, const std::function<double(const glm::dvec3&)>& distance);

}  // namespace typodont::surface
