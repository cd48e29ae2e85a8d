// What it costs to take a stroke back on the CT molar, and to remember it.
#include <fmt/format.h>

#include <algorithm>

#include "engine/app/bench/parts.h"
#include "engine/app/scene.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/carver.h"

namespace typodont {

std::vector<BenchRow> bench_undo(bool quick) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::Carver carver(load_tissue(scene), haptics::tray(scene.servo));
  glm::ivec3 lo, hi;
  carver.volume().bounds(lo, hi);
  const VoxelFrame frame = carver.volume().frame();
  const dvec3 low = frame.to_world(dvec3(lo)), high = frame.to_world(dvec3(hi)), middle = 0.5 * (low + high);
  std::vector<BenchRow> rows;
  Nanos t = 0;
  // Straight through the crown, under its top, in passes side by side.
  for (const int passes : {1, 4, 16}) {
    std::vector<double> back, again;
    std::size_t bytes = 0;
    for (int repeat = 0; repeat < (quick ? 3 : 15); ++repeat) {
      t += kNanosPerSecond;
      for (int pass = 0; pass < passes; ++pass) {
        const double y = middle.y + 0.2e-3 * (pass - 0.5 * passes), z = high.z - 2.5e-3 - 0.1e-3 * repeat;
        for (double x = low.x; x < high.x; x += 0.1e-3) {
          Cut cut;
          cut.index = carver.cuts() + 1, cut.t = t += 1'000'000;
          cut.X_WA.p = {x, y, z}, cut.X_WB.p = {x + 0.1e-3, y, z};
          carver.apply(cut);
        }
      }
      const Nanos start = thread_cpu_time();
      carver.undo();
      const Nanos undone = thread_cpu_time();
      carver.redo();
      again.push_back(static_cast<double>(thread_cpu_time() - undone));
      back.push_back(static_cast<double>(undone - start));
      (void)carver.volume().take_changed_bricks();
      bytes = carver.volume().strokes().bytes;  // of this stroke alone: the one before is forgotten
      carver.undo();                            // the next one meets the same tooth
    }
    const std::string knob = fmt::format("{} passes through the crown", passes);
    const double kilobytes = static_cast<double>(bytes) / 1024;
    rows.push_back({.name = "undo", .knob = knob, .time_ns = quantile(back, 0.5), .per = "stroke", .size = kilobytes, .size_unit = "kB kept"});
    rows.push_back({.name = "redo", .knob = knob, .time_ns = quantile(again, 0.5), .per = "stroke", .size = kilobytes, .size_unit = "kB kept"});
  }
  return rows;
}

}  // namespace typodont
