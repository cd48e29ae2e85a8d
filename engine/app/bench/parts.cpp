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
     "The table gives the error of the force direction while the hand slides on a ball, and the times of cutting ticks "
     "of a simulated hand. The error of a cutting tick compares the removed volume with the volume that the motor's "
     "work allows.",
     contact, true},
    {"models", "Contact models compared",
     "All contact models are compared with the exact solution, with the same tissue, the same hand and the same clock.",
     models, false, write_models_page},
    {"stress", "What each contact model survives",
     "All contact models are tested with hostile hands, invalid input, carver stalls, uneven clocks, forces of 200 N, "
     "fast probes and thin walls.",
     stress, false, write_stress_page},
    {"motions", "Motions of a hand",
     "The table gives the time of the servo's tick for every shipped tool. The tool is first pressed into a block of "
     "0.1 mm voxels and then moved like a hand. Each cell gives the median, the 99 % and the 99.9 % quantile of the "
     "tick's time in µs. For comparison, half of the tick's period is 500 µs.",
     motions, false, nullptr, motions_table},
    {"packing", "Sphere packings",
     "A ball of 10 mm is packed with spheres. The table gives the unfilled fraction of the ball, and the time of the "
     "first contact with a search tree of the tissue or of the tool. The table also gives the error of the normal's "
     "direction, the volume of a groove by the published and by the corrected formula, and the times of the three "
     "passes of a cutting tick.",
     [](const BenchRun& run) { return haptics::bench_packing(run.quick); }},
    {"mesh_lod", "Triangle meshes",
     "The tip of an explorer (a probe) slides over a dental arch at 30 mm/s, 0.3 mm deep, on meshes with increasing "
     "numbers of vertices. Then burs cut into a cusp, and widen a cavity 1.5 mm deep. The removed volume is compared "
     "with that of the model `offset` with the same hand.",
     mesh_lod},
    {"vertex", "Vertex deformation",
     "In one test, a round bur slides over the dental arch, and in another test, it carves the arch, with meshes of "
     "increasing size. The time of a tick depends on the part of the mesh near the head. Then burs widen a cavity 1.5 "
     "mm deep. The removed volume is compared with that of the model `offset` with the same hand.",
     vertex},
    {"implant", "Implant surgery",
     "The table gives the times of ticks of the contact model `implant`, with tool voxels of 0.06 mm and bone voxels "
     "of 0.15 mm. The tools move freely on the bone and in an implant bed.",
     [](const BenchRun& run) { return haptics::bench_implant(run.quick); }},
    {"mesh_picture", "Picture of a carved mesh",
     "A round bur carves a molar of four tissues, and the dental arch. The program prepares the changed part of the "
     "mesh for drawing and uploads it 60 times per second.",
     bench_mesh_picture},
    {"stability", "Stability",
     "The first rows give the critical stiffness of a wall, for different servo rates, delays and jitter. At the "
     "critical stiffness, a mass (0.15 kg, 5 N·s/m) that is pushed against the wall no longer comes to rest. The other "
     "rows give the force on hands at the molar while the carver thread stalls, compared with other force laws.",
     bench_stability},
    {"push", "Force steps of a constant push",
     "2,000 simulated hands push every turning tool into the molar with a constant force (docs/passivity.md). The "
     "table states how many hands feel a force change of more than 0.02 N in one tick, and how many feel a change "
     "larger than their own motion explains. The table compares the present force laws with version 7, and "
     "contains no times.",
     bench_push},
    {"devices", "Hands",
     "The table gives the time from a device's sample to the force that is written to the device, compared with an "
     "empty loop. The table also gives the error of the estimated velocity at an arm's encoder resolution. The link to "
     "the "
     "device is simulated in memory, so the time of USB is not included.",
     devices},
    {"surface", "Surface",
     "The table gives the time to compute triangles from the distance field. The first rows are for a sphere of 50 "
     "voxels. The next rows are for the whole molar and for one frame of drilling, with and without the tissues that "
     "are visible below the surface, compared with volumeToMesh of the whole molar. The last rows are for a ball, "
     "compared with volumeToMesh at equal error. A ratio of 0.02 means 50 times as fast as the other method, and a "
     "ratio of 0.33 means 3 times as fast.",
     bench_surface},
    {"debris", "Debris",
     "The table gives the time of one simulation step of all particles, compared with the time to read and write their "
     "memory once.",
     debris},
    {"render", "Picture",
     "The table gives the time of a stereo frame of the molar during drilling, for each quality level. The error of a "
     "frame is its difference from a picture of the best quality level at twice the size.",
     bench_render},
    {"looks", "Look",
     "The picture of each quality level is compared with a path tracer's picture of the same scene (tests/reference). "
     "The table gives the mean FLIP (0 to 1) and the mean CIEDE2000 difference.",
     bench_looks},
    {"sound", "Sound",
     "The table gives the errors of autoregressive models of a recorded drill, and the times of the filters that "
     "synthesize sound from these models.",
     sound},
    {"calibration", "Calibration",
     "The table gives the time and the error of every solver of the calibration for different numbers of touches, "
     "compared with the libraries Eigen and OpenCV.",
     calibration},
    {"recording", "Recording",
     "A session with a minute of drilling at 1 kHz is recorded to an HDF5 file, with different compression levels.",
     bench_recording},
    {"latency", "Latency",
     "The table gives delays of the whole program as wall-clock times. The delays are the times from a step of the "
     "hand to force, sound and picture, and the times from the start of the command to the first tick and to the first "
     "picture. The table also gives the energy of a session at rest and of a session that drills, in core-seconds per "
     "minute of all threads.",
     bench_latency},
    {"import", "Import",
     "Scans and meshes of clinical size are imported. The table gives the CPU time per voxel, and the peak memory "
     "compared with the memory that the program estimated before the import.",
     bench_import},
    {"undo", "Undo",
     "The table gives the times of undo and redo of a stroke, and the memory that undo needs. The stroke is made on "
     "the CT molar, and with several burs in a block of 0.05 mm voxels.",
     bench_undo},
    {"scaling", "Scaling",
     "The same drilling is measured in bodies of increasing size. Some times must not grow with the size of the body, "
     "and other times grow with its surface.",
     bench_scaling},
    {"length", "Length",
     "The benchmark simulates a session of eight hours. In each minute, the hand drills a pit, fills the pit and "
     "probes it. The whole session is recorded, and every stroke can be undone. Each row of the table covers the time "
     "since the previous row. The memory grows because the undo history is unlimited by design. The overhead of this "
     "history in the allocator and the index of the recording's chunks also make the memory grow.",
     bench_length}};

}  // namespace

std::span<const BenchPart> bench_parts() {
  return kParts;
}

}  // namespace typodont
