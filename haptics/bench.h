// Benchmarks of contact and cutting for the command `typodont bench`: each row gives a time and an error.
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
  int ticks = 2000;  // number of ticks per run; the 99.9th percentile needs at least a thousand ticks
  std::vector<double> voxels_mm = {0.2, 0.1, 0.05};
  SharedContactMethod method;  // contact model to measure; null: the default model
};

/// Measures one contact model while a tool slides, drills and moves freely, and measures how often it misses a
/// deadline. The default model also gets rows for its single parts (queries of the distance field, cuts alone,
/// patches).
std::vector<BenchRow> bench_contact(const BenchOptions& options);
/// Measures packings (tissue as spheres) of a ball-shaped tissue with different numbers of spheres: filled fraction,
/// collision, normals, removal and tick time. `quick`: leaves out the largest packing and repeats less often.
std::vector<BenchRow> bench_packing(bool quick);

/// A tissue mesh with the point at which the hand begins contact, for the comparison of contact models. Metres,
/// workbench frame W.
struct ModelAnatomy {
  std::string name;
  TissueMesh mesh;  // exact surface of the anatomy
  std::function<TissueVolume(double voxel_mm)> make;
  dvec3 start{0};  // point on the surface where the hand makes contact
  // unit vector that points out of the tissue at `start`; the hand approaches in the opposite direction
  dvec3 out{0, 0, 1};
  // mm, from coarse to fine, at least one: voxel sizes with which the contact models are measured. An anatomy that was
  // read from a voxel file has only one voxel size, that of the file.
  std::vector<double> voxels_mm;
};

struct ModelBenchOptions {
  // true: few ticks and coarse settings, for an overview; the results are then not reliable
  bool quick = false;
  std::vector<std::string> tissues;  // names of the tissues to use; empty: all
  // Motions to use: "slide", "tap", "drag", "drill", "break-through", "escape", "hostile"; empty: all.
  std::vector<std::string> motions;
  std::vector<ModelAnatomy> anatomies;
};
/// Names of the built-in tissues with simple shapes, which bench_models() measures in this order. They need no file
/// with an anatomy.
std::vector<std::string> model_bench_tissues();
/// Measures every contact model on the same tissues with the same hand motions, and compares its results with the exact
/// solution. The name of a row has the form "TISSUE, MOTION, MODEL: MEASURED QUANTITY".
std::vector<BenchRow> bench_models(const ModelBenchOptions& options);

struct StressBenchOptions {
  bool quick = false;               // true: few ticks, for an overview; a complete test needs false
  std::vector<std::string> models;  // names of the models to use; empty: all
  // meshes for the test with a fast probe, in addition to the built-in edges and the built-in groove
  std::vector<ModelAnatomy> meshes;
};
/// Tests the safety of every contact model: motions faster than a human's, invalid input, a carver thread that is late,
/// an irregular clock, a push of 200 N, fast probes and thin walls. The name of a row consists of the kind of test, the
/// model and the measured quantity. The ratio of a row is the measured value divided by the largest permitted value.
std::vector<BenchRow> bench_stress(const StressBenchOptions& options);

struct MotionBenchOptions {
  std::filesystem::path tools;     // folder of tool files
  std::vector<std::string> names;  // names of the tools to use; empty: all
  double voxel_mm = 0.1;
  // number of measured ticks per tool and motion; the measurement begins when the tool has sunk into the tissue
  int ticks = 1000;
};
/// Measures the thread CPU time of a servo tick for every tool and every hand motion (up to 20 rad/s and 0.5 m/s).
std::vector<BenchRow> bench_motions(const MotionBenchOptions& options);
/// Measures the time of a tick and the memory while the hand slides over a mesh. Repeats this with meshes of more and
/// more vertices.
std::vector<BenchRow> bench_mesh_lod(const TissueMesh& mesh, bool quick);
/// Measures the tick time of the contact model "vertex" on meshes with different numbers of vertices. A round bur
/// slides on the mesh, or cuts it.
std::vector<BenchRow> bench_vertex(const TissueMesh& mesh, bool quick);

}  // namespace typodont::haptics
