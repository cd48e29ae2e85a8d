// How costs grow with the scene: the servo must not feel its size, memory follows the surface.
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>

#include "engine/app/bench/parts.h"
#include "engine/app/haptic_loop.h"
#include "engine/app/tissue_view.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

double allocated_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

}  // namespace

std::vector<BenchRow> bench_scaling(bool quick) {
  std::vector<BenchRow> rows;
  const std::vector<double> radii = quick ? std::vector<double>{3, 6} : std::vector<double>{3, 6, 12, 18};
  for (const double radius_mm : radii) {
    const double voxel = 0.1;
    const Scene scene =
        parse_scene(Json::parse(fmt::format(R"({{"tissue": {{"voxel_mm": {}, "solids": [{{"tissue": "dentin",
          "solid": {{"sphere": {{"radius_mm": {}}}}}}}]}}, "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics"]}})",
                                            voxel, radius_mm),
                                "bench"),
                    {});
    const std::string knob = fmt::format("ball of {:g} mm, voxel {:g} mm", 2 * radius_mm, voxel);
    const double surface = 4 * kPi * std::pow(radius_mm / voxel, 2);  // voxels²
    const auto row = [&](const char* name, double ns, const char* per) {
      rows.push_back(
          {.name = name, .knob = knob, .time_ns = ns, .per = per, .size = surface, .size_unit = "voxels² of surface"});
    };

    const double before = allocated_bytes();
    haptics::TissueVolume tissue = load_tissue(scene);
    const double memory = allocated_bytes() - before;
    rows.push_back({.name = "memory of the tissue",
                    .knob = knob,
                    .error = memory / surface,
                    .error_unit = "bytes a voxel² of surface",
                    .size = surface,
                    .size_unit = "voxels² of surface"});

    TissueView view;
    const Nanos start = thread_cpu_time();
    (void)view.update(tissue);
    row("whole mesh", static_cast<double>(thread_cpu_time() - start), "mesh");

    HapticLoop loop(scene, std::move(tissue), 1000);
    std::vector<double> ticks, frames;
    ServoTick tick;
    Cut cut;
    for (int i = 0; i < (quick ? 300 : 1500); ++i) {
      haptics::HandSample hand;
      hand.t = from_seconds(1e-3 * i);
      hand.X_WT.p = dvec3(1e-3 * std::sin(6e-3 * i), 0, radius_mm * 1e-3 + 0.6e-3 - std::min(0.3e-6 * i, 0.3e-3));
      hand.pedal = 1;
      const Nanos began = thread_cpu_time();
      loop.tick(hand, tick, cut);
      ticks.push_back(static_cast<double>(thread_cpu_time() - began));
      if (i % 16 == 0) {
        const Nanos drew = thread_cpu_time();
        (void)view.update(loop.carver().volume());
        frames.push_back(static_cast<double>(thread_cpu_time() - drew));
      }
    }
    row("servo and carver, drilling tick, median", quantile(ticks, 0.5), "tick");
    row("mesh of what a frame's drilling changed, median", quantile(frames, 0.5), "frame");
  }
  return rows;
}

}  // namespace typodont
