#include "engine/app/bench/parts.h"

#include <cstdlib>

#include "audio/bench.h"
#include "calibration/bench.h"
#include "engine/app/assets.h"
#include "engine/app/bench/model_anatomies.h"
#include "engine/app/bench/models_page.h"
#include "engine/app/bench/motions_table.h"
#include "engine/app/bench/stress_page.h"
#include "engine/app/scene.h"
#include "engine/base/temporary_folder.h"
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
  // The set-up time must include the computation of a packing (tissue as spheres). With an empty cache folder, no
  // earlier result can be used.
  const TemporaryFolder cache;
  setenv("TYPODONT_CACHE", cache.path().c_str(), 1);
  haptics::ModelBenchOptions options;
  options.quick = run.quick;
  options.tissues = run.tissues;
  if (!run.quick) options.anatomies = model_anatomies(run.tissues);
  return haptics::bench_models(options);
}

Rows stress(const BenchRun& run) {
  haptics::StressBenchOptions options;
  options.quick = run.quick;
  if (!run.quick) options.meshes = model_anatomies({"arch"});
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
     "Error of the force direction while sliding on a ball, cutting ticks of a simulated hand, and removed volume "
     "compared with the formula.",
     contact, true},
    {"models", "Contact models compared",
     "All contact models with the same tissue, the same hand and the same clock, compared with the exact solution.",
     models, false, write_models_page},
    {"stress", "What each contact model survives",
     "All contact models with hostile hands, invalid input, carver stalls, uneven clocks, 200 N, fast probes and thin "
     "walls.",
     stress, false, write_stress_page},
    {"motions", "Motions of a hand",
     "The servo's tick for every shipped tool, which is first pressed into a block of 0.1 mm voxels and then moved "
     "like a hand. Each cell gives the median, the 99 % and the 99.9 % quantile of a tick in µs. Half of the period is "
     "500 µs.",
     motions, false, nullptr, motions_table},
    {"packing", "Sphere packings",
     "A ball of 10 mm packed with spheres: unfilled fraction, first contact with the tree over the tissue or over the "
     "tool, direction of the normal, volume of a groove by the published and by the corrected formula, and the three "
     "passes of a cutting tick.",
     [](const BenchRun& run) { return haptics::bench_packing(run.quick); }},
    {"mesh_lod", "Triangle meshes",
     "The tip of an explorer slides over a dental arch at 30 mm/s, 0.3 mm deep, on meshes of more and more vertices; "
     "then burs cut into a cusp, and widen a cavity 1.5 mm deep.",
     mesh_lod},
    {"vertex", "Vertex deformation",
     "A round bur that slides over the arch and one that carves it, with meshes of rising size: the tick depends on "
     "what is near the head. Then burs widen a cavity 1.5 mm deep.",
     vertex},
    {"implant", "Implant surgery",
     "Ticks of the model `implant` with tools of 0.06 mm voxels, moving freely on the bone and in a bed; bone voxels "
     "of 0.15 mm.",
     [](const BenchRun& run) { return haptics::bench_implant(run.quick); }},
    {"mesh_picture", "Picture of a carved mesh",
     "A round bur carves a molar of four tissues, and the arch; 60 times per second, the changed part of the mesh is "
     "prepared for drawing and uploaded.",
     bench_mesh_picture},
    {"stability", "Stability",
     "The stiffness at which a pushed mass (0.15 kg, 5 N·s/m) no longer settles at a wall, for different rates, delays "
     "and jitter; and the force on hands at the molar during a stall of the carver, compared with other force laws.",
     bench_stability},
    {"push", "Force steps of a constant push",
     "2,000 simulated hands push every turning tool into the molar with a constant force (docs/passivity.md): how many "
     "feel the force change by more than 0.02 N in one tick, and by more than their own motion explains, by the "
     "present servo laws and by the version before. Not a timing.",
     bench_push},
    {"devices", "Hands",
     "Time from a device's sample to its written force, compared with an empty loop, and the error of the velocity "
     "estimate at an arm's encoder resolution. The link is in memory, so the time of USB is not included.",
     devices},
    {"surface", "Surface",
     "From distance field to triangles: a sphere of 50 voxels; then, with the tissues visible below the surface, the "
     "whole molar and its drilling frames, compared with volumeToMesh of the whole molar, and a ball at equal error. "
     "Ratios of 0.02 and 0.33 mean 50 and 3 times as fast.",
     bench_surface},
    {"debris", "Debris", "A step of all particles, compared with reading and writing the same memory once.", debris},
    {"render", "Picture",
     "A stereo frame of the molar while it is drilled, for each step of the quality ladder; the error is relative to "
     "the best step at twice the size.",
     bench_render},
    {"looks", "Look",
     "The picture of each step of the quality ladder, compared with a path tracer's picture of the same scene "
     "(tests/reference): mean FLIP, 0 to 1, and mean CIEDE2000.",
     bench_looks},
    {"sound", "Sound", "Autoregressive models of a recorded drill, and the filters that synthesize sound from them.",
     sound},
    {"calibration", "Calibration",
     "Time and error of every solver for different numbers of touches, compared with Eigen and OpenCV.", calibration},
    {"recording", "Recording", "A minute of drilling at 1 kHz into HDF5, for different compression levels.",
     bench_recording},
    {"latency", "Latency",
     "The whole program: from a step of the hand to force, sound and picture; from the command to the first of them. "
     "Wall-clock times. Then the energy of a session at rest and of one that drills: core-seconds per minute of all "
     "its threads, and the power of the processor package where the machine measures it.",
     bench_latency},
    {"import", "Import",
     "Scans and meshes of clinical size: CPU time per voxel, and peak memory compared with the estimate before the "
     "work.",
     bench_import},
    {"undo", "Undo",
     "Undo and redo of a stroke, and the memory it needs: on the CT molar, and with several burs in a block of 0.05 mm "
     "voxels.",
     bench_undo},
    {"scaling", "Scaling",
     "The same drilling in bodies of increasing size: times that must not grow, and times that grow with the surface.",
     bench_scaling},
    {"length", "Length",
     "Eight hours in simulated time: pits drilled, filled and felt, all recorded, every stroke kept for undo. Each row "
     "covers the time since the previous row. Memory grows with the undo history, which is unlimited by design, "
     "its overhead in the allocator, and the index of the recording's chunks.",
     bench_length}};

}  // namespace

std::span<const BenchPart> bench_parts() {
  return kParts;
}

}  // namespace typodont
