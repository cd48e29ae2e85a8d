// Measures how costs grow with the size of the scene. The time of a tick must not depend on the size. The memory must
// grow only with the surface.
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>

#include "engine/app/assets.h"
#include "engine/app/bench/parts.h"
#include "engine/app/haptic_loop.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

// mm, width of the band of stored distances around the surface; the width is equal for all bodies, so that their memory
// can be compared
constexpr double kBand = 1.0;

double allocated_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

struct Body {
  std::string knob, tissue;
  dvec3 top;       // m, point at which the drill enters the body from above
  double surface;  // voxels², area of the body's surface
};

Body ball(double radius_mm) {
  const double voxel = 0.1;
  return {
      fmt::format("ball of {:g} mm, voxel {:g} mm", 2 * radius_mm, voxel),
      fmt::format(
          R"({{"voxel_mm": {}, "band_mm": {}, "solids": [{{"tissue": "dentin", "solid": {{"sphere": {{"radius_mm": {}}}}}}}]}})",
          voxel, kBand, radius_mm),
      {0, 0, radius_mm * 1e-3},
      4 * kPi * std::pow(radius_mm / voxel, 2)};
}

/// Makes a dental arch: fourteen teeth on a parabola, each with an enamel crown, a dentin core and a root.
Body dental_arch() {
  std::string solids;
  dvec3 first(0);
  double area = 0;  // mm², area of the surface of all teeth so far
  for (int i = 0; i < 14; ++i) {
    const double along = (i - 6.5) / 6.5, x = 26 * along, y = -38 * along * along, radius = 2.6 + 2 * along * along;
    for (const bool core : {false, true}) {
      const double r = core ? radius - 1.2 : radius;
      solids += fmt::format(
          R"({}{{"tissue": "{}", "solid": {{"capsule": {{"a_mm": [{:.3f}, {:.3f}, 0], "b_mm": [{:.3f}, {:.3f}, {}],
        "radius_mm": {:.3f}}}}}}})",
          solids.empty() ? "" : ", ", core ? "dentin" : "enamel", x, y, x, y, core ? -10 : -3, r);
    }
    if (i == 6) first = dvec3(x, y, radius) * 1e-3;
    area += 2 * kPi * radius * (2 * radius + 10);
  }
  return {"dental arch, 14 teeth, voxel 0.05 mm",
          fmt::format(R"({{"voxel_mm": 0.05, "band_mm": {}, "solids": [{}]}})", kBand, solids), first,
          area / std::pow(0.05, 2)};
}

/// Makes a hip: a femoral head in its socket.
Body hip() {
  return {"hip, voxel 0.1 mm",
          fmt::format(R"({{"voxel_mm": 0.1, "band_mm": {}, "solids": [
      {{"tissue": "cortical_bone", "solid": {{"difference": [{{"sphere": {{"radius_mm": 33}}}}, {{"sphere": {{"radius_mm": 26}}}}]}}}},
      {{"tissue": "cortical_bone", "solid": {{"sphere": {{"radius_mm": 24}}}}}},
      {{"tissue": "cancellous_bone", "solid": {{"sphere": {{"radius_mm": 21.5}}}}}}]}})",
                      kBand),
          {0, 0, 33e-3},
          4 * kPi * (33. * 33 + 26. * 26 + 24. * 24) / std::pow(0.1, 2)};
}

/// Measures the picture in a close view of the drilled position. In this view, the cost of a frame must not depend on
/// the size of the body.
void picture_row(const Body& body, const Scene& scene, haptics::TissueVolume& tissue, ServoTick tick, bool quick,
                 std::vector<BenchRow>& rows) {
  const auto fast = std::find_if(render::kQualityLadder.begin(), render::kQualityLadder.end(),
                                 [](const render::Quality& q) { return std::string_view(q.name) == "fast"; });
  display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  const dvec3 middle = 0.5 * (rig.screen.upper_left + rig.screen.lower_right), way = body.top - middle;
  for (dvec3* p : {&rig.screen.lower_left, &rig.screen.lower_right, &rig.screen.upper_left, &rig.head.eye_center})
    *p += way;
  PictureStage::Options options;
  options.quality = *fast;
  PictureStage stage(rig, scene.servo, options);
  const auto bricks = TissueView(surface_tolerance(rig, tissue.frame().voxel, *fast)).update(tissue);
  stage.show(bricks, tissue.frame().origin);
  const render::FrameStats stats = stage.draw(tick, {}, 0);
  std::vector<double> times;
  for (int i = 0; i < (quick ? 3 : 15); ++i) {
    const std::clock_t began = std::clock();
    tick.X_WG.p.x += 1e-5;
    stage.draw(tick, {}, 1.0 / 60);
    times.push_back(1e9 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
  }
  rows.push_back({.name = fmt::format("stereo frame from close by, tool moving, {}, all threads", fast->name),
                  .knob = fmt::format("{}, {} of {} bricks seen", body.knob, stats.bricks_drawn, bricks.size()),
                  .time_ns = quantile(times, 0.5),
                  .per = "frame",
                  .size = body.surface,
                  .size_unit = "voxels² of surface"});
}

}  // namespace

std::vector<BenchRow> bench_scaling(const BenchRun& run) {
  std::vector<BenchRow> rows;
  std::vector<Body> bodies{ball(3), ball(6)};
  if (!run.quick) bodies.insert(bodies.end(), {ball(12), ball(18), dental_arch(), hip()});
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("typodont_scaling_{}.vdb", ::getpid());
  for (const Body& body : bodies) {
    const auto scene_of = [&](const std::string& tissue) {
      return parse_scene(
          Json::parse(fmt::format(R"({{"tissue": {}, "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics"]}})",
                                  tissue),
                      "bench"),
          {});
    };
    const Scene scene = scene_of(body.tissue);
    const auto row = [&](const char* name, double ns, const char* per) {
      rows.push_back({.name = name,
                      .knob = body.knob,
                      .time_ns = ns,
                      .per = per,
                      .size = body.surface,
                      .size_unit = "voxels² of surface"});
    };

    std::filesystem::remove(file);  // removes the file of the previous body
    load_tissue(scene).save(file);
    const Scene saved = scene_of(fmt::format(R"({{"volume": "{}"}})", file.string()));
    const double before = allocated_bytes();
    Nanos began = now();
    haptics::TissueVolume tissue = load_tissue(saved);
    row("start: the tissue from its file, wall time", static_cast<double>(now() - began), "start");
    const double memory = allocated_bytes() - before;
    rows.push_back({.name = "memory of the tissue",
                    .knob = body.knob,
                    .error = memory / body.surface,
                    .error_unit = "bytes a voxel² of surface",
                    .size = body.surface,
                    .size_unit = "voxels² of surface"});

    TissueView view;
    began = thread_cpu_time();
    (void)view.update(tissue);
    row("whole mesh", static_cast<double>(thread_cpu_time() - began), "mesh");

    HapticLoop loop(scene, std::move(tissue), 1000);
    std::vector<double> servo, carver, frames;
    ServoTick tick;
    Cut cut;
    for (int i = 0; i < (run.quick ? 300 : 1500); ++i) {
      haptics::HandSample hand;
      hand.t = from_seconds(1e-3 * i);
      hand.X_WT.p = body.top + dvec3(1e-3 * std::sin(6e-3 * i), 0, 0.6e-3 - std::min(0.3e-6 * i, 0.3e-3));
      hand.pedal = 1;
      began = thread_cpu_time();
      loop.tick(hand, tick, cut);
      servo.push_back(static_cast<double>(tick.cpu_time));
      carver.push_back(static_cast<double>(thread_cpu_time() - began - tick.cpu_time));
      if (i % 16 == 0) {
        began = thread_cpu_time();
        (void)view.update(loop.carver().volume());
        frames.push_back(static_cast<double>(thread_cpu_time() - began));
      }
    }
    row("servo, drilling tick, median", quantile(servo, 0.5), "tick");
    row("carver, the same cuts in the whole tissue, median", quantile(carver, 0.5), "tick");
    row("mesh of what a frame's drilling changed, median", quantile(frames, 0.5), "frame");
    picture_row(body, scene, loop.carver().volume(), tick, run.quick, rows);
  }
  std::filesystem::remove(file);
  return rows;
}

}  // namespace typodont
