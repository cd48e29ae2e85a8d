// What the surface costs and how true it is: work-precision rows for `typodont bench`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "engine/surface/mesh_export.h"

namespace typodont::surface {

struct BenchOptions {
  int repeats = 9;
  std::vector<double> tolerances = {-1, 0, 0.05, 0.1, 0.2};  // voxels; negative: full resolution
  double floor_32 = 6.5e-6;                                  // s, the floor of a 32³ dirty block (a mean of 5–8 µs)
};

/// A sphere of 50 voxels: N·ε/R in `error`, time per brick against the floor.
std::vector<BenchRow> bench_sphere(const BenchOptions& options);

/// Greatest |distance| over a fine net of points on every triangle.
double greatest_error(const WholeMesh& mesh, const std::function<double(const glm::dvec3&)>& distance);

}  // namespace typodont::surface
