// Time and accuracy of contact and cutting: work-precision rows for `typodont bench`.
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
  int ticks = 2000;  // ticks per run; the 99.9th percentile needs at least a thousand
  std::vector<double> voxels_mm = {0.2, 0.1, 0.05};
  SharedContactMethod method;  // contact model to measure; null: the default model
};

/// Measures sliding, drilling, removal, free air and deadlines with one contact model. The default model also gets rows
/// for its own parts (queries, cuts alone, patches).
std::vector<BenchRow> bench_contact(const BenchOptions& options);
/// Measures sphere packings of a ball: coverage, collision, normals, removal and ticks, for different numbers of
/// spheres. `quick`: without the largest packing, and with fewer repeats.
std::vector<BenchRow> bench_packing(bool quick);

/// An anatomy for the comparison of contact models. Metres, frame W.
struct ModelAnatomy {
  std::string name;
  TissueMesh mesh;  // exact surface of the anatomy
  std::function<TissueVolume(double voxel_mm)> make;
  dvec3 start{0};      // point on the surface at which the hand touches down
  dvec3 out{0, 0, 1};  // unit, direction out of the surface, from which the hand comes
  // Voxel sizes from coarse to fine, at least one; a voxel file has only its own size
  std::vector<double> voxels_mm;
};

struct ModelBenchOptions {
  bool quick = false;                // few ticks and coarse settings: an overview, not a measurement
  std::vector<std::string> tissues;  // names of the anatomies to use; empty: all
  // Motions to use: "slide", "tap", "drag", "drill", "break-through", "escape", "hostile"; empty: all.
  std::vector<std::string> motions;
  std::vector<ModelAnatomy> anatomies;
};
/// Measures every contact model on the same tissues with the same hands, and compares with the exact answer. A row's
/// name is "tissue, motion, model: measure".
std::vector<BenchRow> bench_models(const ModelBenchOptions& options);

struct StressBenchOptions {
  bool quick = false;                // few ticks: an overview, not a campaign
  std::vector<std::string> models;   // names of the models to use; empty: all
  std::vector<ModelAnatomy> meshes;  // meshes for the fast probe, in addition to edges and a groove
};
/// Tests every contact model with motions that no human makes, invalid input, late carvers, irregular clocks, 200 N,
/// fast probes and thin walls. A row's name is "campaign, model: measure"; its ratio is relative to the largest value
/// that passes.
std::vector<BenchRow> bench_stress(const StressBenchOptions& options);

struct MotionBenchOptions {
  std::filesystem::path tools;     // folder of tool files
  std::vector<std::string> names;  // names of the tools to use; empty: all
  double voxel_mm = 0.1;
  int ticks = 1000;  // ticks per tool and motion, after the tool has sunk in
};
/// Measures the servo's tick for every tool and every motion of a hand (20 rad/s, 0.5 m/s): thread CPU time.
std::vector<BenchRow> bench_motions(const MotionBenchOptions& options);
/// Measures tick time and memory of a hand that slides over a mesh, for increasing numbers of vertices.
std::vector<BenchRow> bench_mesh_lod(const TissueMesh& mesh, bool quick);
/// Measures the tick of the model "vertex" on meshes with different numbers of vertices: a round bur slides, or carves.
std::vector<BenchRow> bench_vertex(const TissueMesh& mesh, bool quick);

}  // namespace typodont::haptics
