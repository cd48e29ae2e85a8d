// What touching and cutting cost and how true they are: work-precision rows for `typodont bench`.
#pragma once

#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

struct BenchOptions {
  int ticks = 2000;  // per run; the 99.9th percentile wants a thousand or more
  std::vector<double> voxels_mm = {0.2, 0.1, 0.05};
};

std::vector<BenchRow> bench_contact(const BenchOptions& options);
/// Sphere packings of a ball: coverage, collision, normals, removal and ticks, by the number of spheres. `quick`:
/// without the largest packing, and fewer repeats.
std::vector<BenchRow> bench_packing(bool quick);

/// A hand that slides over a mesh subdivided and simplified to rising numbers of vertices: time of a tick, memory.
std::vector<BenchRow> bench_mesh_lod(const TissueMesh& mesh, bool quick);
/// A round bur that slides over such a mesh, and one that carves it (model vertex): time of a tick.
std::vector<BenchRow> bench_vertex(const TissueMesh& mesh, bool quick);

}  // namespace typodont::haptics
