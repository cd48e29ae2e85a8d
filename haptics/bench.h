// What touching and cutting cost and how true they are: work-precision rows for `typodont bench`.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/contract/bench_row.h"
#include "haptics/contact_method.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

struct BenchOptions {
  int ticks = 2000;  // per run; the 99.9th percentile wants a thousand or more
  std::vector<double> voxels_mm = {0.2, 0.1, 0.05};
  SharedContactMethod method;  // the contact model that is measured; null: the default one
};

/// Sliding, drilling, removal, free air and deadlines by one contact model. Rows of the default model's own parts
/// (queries, cuts alone, patches) are only there for the default model.
std::vector<BenchRow> bench_contact(const BenchOptions& options);
/// Sphere packings of a ball: coverage, collision, normals, removal and ticks, by the number of spheres. `quick`:
/// without the largest packing, and fewer repeats.
std::vector<BenchRow> bench_packing(bool quick);

/// An anatomy for the comparison of contact models. Metres, frame W.
struct ModelAnatomy {
  std::string name;
  TissueMesh mesh;  // its exact surface
  std::function<TissueVolume(double voxel_mm)> make;
  dvec3 start{0};                 // on the surface: where the hand comes down …
  dvec3 out{0, 0, 1};             // … from this direction
  std::vector<double> voxels_mm;  // coarse to fine, at least one; of a file of voxels its own
};

struct ModelBenchOptions {
  bool quick = false;                // few ticks and coarse settings: a look instead of a measurement
  std::vector<std::string> tissues;  // of them; none: all
  // "slide", "tap", "drag", "drill", "break-through", "escape", "hostile"; none: all
  std::vector<std::string> motions;
  std::vector<ModelAnatomy> anatomies;
};
/// Every contact model on the same tissues with the same hands, against the exact answer. The name of a row is
/// "tissue, motion, model: measure".
std::vector<BenchRow> bench_models(const ModelBenchOptions& options);

struct StressBenchOptions {
  bool quick = false;                // few ticks: a look instead of a campaign
  std::vector<std::string> models;   // of them; none: all
  std::vector<ModelAnatomy> meshes;  // that a fast probe slides over, besides edges and a groove
};
/// Every contact model under hands that no human has, nonsense, late carvers, uneven clocks, 200 N, fast probes and
/// thin walls. The name of a row is "campaign, model: measure"; its ratio is to the most that passes.
std::vector<BenchRow> bench_stress(const StressBenchOptions& options);

struct MotionBenchOptions {
  std::filesystem::path tools;     // folder of tool files
  std::vector<std::string> names;  // of them; none: all
  double voxel_mm = 0.1;
  int ticks = 1000;  // per tool and motion, after the tool has sunk in
};
/// The servo's tick for every tool and every motion of a hand (20 rad/s, 0.5 m/s): thread CPU time.
std::vector<BenchRow> bench_motions(const MotionBenchOptions& options);
/// A hand that slides over a mesh subdivided and simplified to rising numbers of vertices: time of a tick, memory.
std::vector<BenchRow> bench_mesh_lod(const TissueMesh& mesh, bool quick);
/// A round bur that slides over such a mesh, and one that carves it (model vertex): time of a tick.
std::vector<BenchRow> bench_vertex(const TissueMesh& mesh, bool quick);

}  // namespace typodont::haptics
