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
  // voxels, values of SurfaceMesher's option `tolerance` for which a mesh is made and measured; negative: cells are not
  // merged
  std::vector<double> tolerances = {-1, 0, 0.05, 0.1, 0.2};
  // s, assumed shortest possible time for meshing a changed block of 32³ samples (5 to 8 µs were measured). The
  // measured times are compared with this time.
  double floor_32 = 6.5e-6;
};

/// Meshes a sphere with a radius R of 50 voxels, once for each tolerance. `error` is N·ε/R with the number N of
/// triangles and the largest distance ε between mesh and sphere. The measured time is the time per brick of 16³ cells.
/// It is compared with floor_32 / 8, because floor_32 is the time for 32³ samples.
std::vector<BenchRow> bench_sphere(const BenchOptions& options);

/// Returns the largest |distance(p)| over a fine grid of points p on every triangle of the mesh.
double largest_error(const WholeMesh& mesh, const std::function<double(const glm::dvec3&)>& distance);

}  // namespace typodont::surface
