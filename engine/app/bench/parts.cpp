#include "engine/app/bench/parts.h"

#include "audio/bench.h"
#include "calibration/bench.h"
#include "engine/app/assets.h"
#include "engine/app/bench/model_anatomies.h"
#include "engine/app/bench/models_page.h"
#include "engine/app/bench/stress_page.h"
#include "engine/app/scene.h"
#include "engine/base/units.h"
#include "engine/debris/bench.h"
#include "haptics/bench.h"
#include "haptics/device_bench.h"
#include "haptics/implant_bench.h"
#include "haptics/import/mesh_tissue.h"

namespace typodont {

namespace {

using Rows = std::vector<BenchRow>;

Rows contact(const BenchRun& run) {
  haptics::BenchOptions options;
  options.method = run.method;
  if (run.quick) options.ticks = 300, options.voxels_mm = {0.2, 0.1};
  return haptics::bench_contact(options);
}

haptics::TissueMesh arch() {
  return haptics::read_tissue_mesh(assets_folder() / "jaw/lower_arch.ply", kMillimetre, Tissue::kEnamel).mesh;
}
Rows mesh_lod(const BenchRun& run) {
  return haptics::bench_mesh_lod(arch(), run.quick);
}
Rows vertex(const BenchRun& run) {
  return haptics::bench_vertex(arch(), run.quick);
}

Rows models(const BenchRun& run) {
  haptics::ModelBenchOptions options;
  options.quick = run.quick;
  if (!run.quick) options.anatomies = model_anatomies();
  return haptics::bench_models(options);
}

Rows stress(const BenchRun& run) {
  haptics::StressBenchOptions options;
  options.quick = run.quick;
  if (!run.quick) {
    options.meshes = model_anatomies();
    std::erase_if(options.meshes, [](const haptics::ModelAnatomy& a) { return a.name != "arch"; });
  }
  return haptics::bench_stress(options);
}

Rows motions(const BenchRun& run) {
  haptics::MotionBenchOptions options;
  options.tools = assets_folder() / "tools";
  if (run.quick) options.names = {"round_012", "flame_018", "implant_drill_042"}, options.ticks = 400;
  return haptics::bench_motions(options);
}

Rows devices(const BenchRun& run) {
  haptics::DeviceBenchOptions options;
  options.assets = assets_folder();
  if (run.quick) options.ticks = 5000;
  return haptics::bench_devices(options);
}

Rows debris(const BenchRun& run) {
  debris::BenchOptions options;
  if (run.quick) options.repeats = 50;
  return debris::bench_debris(options);
}

Rows sound(const BenchRun& run) {
  audio::BenchOptions options;
  options.recording = assets_folder() / "sounds/micromotor_steady.wav";
  if (run.quick) options.orders = {16, 300}, options.repeats = 3;
  return audio::audio_bench(options);
}

Rows calibration(const BenchRun& run) {
  return calibration::bench_rows(run.quick);
}

constexpr BenchPart kParts[] = {
    {"contact", "Contact and cutting",
     "Direction of the force while sliding on a ball, cutting ticks of a simulated hand, removed volume against the "
     "formula.",
     contact, true},
    {"models", "Contact models compared",
     "Every contact model on the same tissue, with the same hand and the same clock, against the exact answer.", models,
     false, write_models_page},
    {"stress", "What each contact model survives",
     "Every contact model under hostile hands, nonsense, late carvers, uneven clocks, 200 N, fast probes, thin walls.",
     stress, false, write_stress_page},
    {"motions", "Motions of a hand",
     "The servo's tick for every shipped tool, sunk into a block of 0.1 mm voxels and then moved as a hand moves it. "
     "What counts is the 99.9 %: half of the period is 500 µs.",
     motions},
    {"packing", "Sphere packings",
     "A ball of 10 mm packed with spheres: what they leave unfilled, first contact with the tree on either side, "
     "direction "
     "of the normal, a groove's volume as printed in the paper and mended, and the three passes of a cutting tick.",
     [](const BenchRun& run) { return haptics::bench_packing(run.quick); }},
    {"mesh_lod", "Triangle meshes",
     "The tip of an explorer slides over a dental arch at 30 mm/s, 0.3 mm deep, on meshes of more and more vertices; "
     "then burs cut into a cusp, and widen a cavity 1.5 mm deep.",
     mesh_lod},
    {"vertex", "Vertex deformation",
     "A round bur that slides over the arch and one that carves it, with meshes of rising size: the tick depends on "
     "what "
     "is near the head. Then burs widen a cavity 1.5 mm deep.",
     vertex},
    {"implant", "Implant surgery",
     "Ticks of the model implant with tools of 0.06 mm voxels, free on the bone and in a bed; bone voxels of 0.15 mm.",
     [](const BenchRun& run) { return haptics::bench_implant(run.quick); }},
    {"mesh_picture", "Picture of a carved mesh",
     "A round bur carves a molar of four tissues, and the arch; 60 times a second what changed of the mesh is made "
     "ready for the picture and uploaded.",
     bench_mesh_picture},
    {"stability", "Stability",
     "The stiffness at which a pushed mass (0.15 kg, 5 N·s/m) no longer settles at a wall, by rate, delay and jitter; "
     "and what hands on the molar feel while the carver stands still, beside other laws for that.",
     bench_stability},
    {"devices", "Hands",
     "From a device's sample to its force written, beside the same loop with no work in it, and how well a hand's "
     "velocity is known at an arm's quantisation. The link is memory: our share, not USB's.",
     devices},
    {"surface", "Surface",
     "From distance field to triangles: a sphere of 50 voxels; then, with what is seen beneath the surface, the "
     "molar's "
     "whole and its drilling frames beside volumeToMesh's whole, and a ball at equal error. Ratios of 0.02 and 0.33 "
     "are "
     "50 and 3 times as fast.",
     bench_surface},
    {"debris", "Debris", "A step of all particles beside reading and writing the same memory once.", debris},
    {"render", "Picture",
     "A stereo frame of the molar while it is drilled, step by step of the quality ladder; the error is against the "
     "best "
     "step at twice the size.",
     bench_render},
    {"sound", "Sound", "Autoregressive models of a recorded drill, and the filters that play them.", sound},
    {"calibration", "Calibration", "Every solver against the number of touches, beside Eigen's and OpenCV's own.",
     calibration},
    {"recording", "Recording", "A minute of drilling at 1 kHz into HDF5, by strength of compression.", bench_recording},
    {"latency", "Latency",
     "The whole program: from a step of the hand to force, sound and picture; from the command to the first of them. "
     "Wall clock.",
     bench_latency},
    {"import", "Import",
     "Scans and meshes in the sizes that clinics have: processor time per voxel, the most memory at a time beside the "
     "estimate that is made before the work begins.",
     bench_import},
    {"undo", "Undo",
     "A stroke taken back and brought again, and the memory it takes: on the CT molar, and by several burs in a block "
     "of 0.05 mm voxels.",
     bench_undo},
    {"scaling", "Scaling",
     "The same drilling in ever larger bodies: what must not grow, and what grows with the surface.", bench_scaling},
    {"length", "Length",
     "Eight hours in simulated time: pits drilled, filled and felt, all recorded, every stroke kept for undo. Each row "
     "is "
     "of what was done since the row before it. Memory grows by what is kept for undo, which has no end by contract, "
     "with the "
     "allocator's share of it, and by where the recording's chunks are.",
     bench_length}};

}  // namespace

std::span<const BenchPart> bench_parts() {
  return kParts;
}

}  // namespace typodont
