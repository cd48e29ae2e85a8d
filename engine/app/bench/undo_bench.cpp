// Measures the cost of storing a stroke and of undoing it, on the CT molar and on a block of fine voxels with burs of
// all sizes.
#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>

#include "engine/app/assets.h"
#include "engine/app/bench/parts.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/carver.h"

namespace typodont {

namespace {

constexpr std::string_view kBlock = R"({"name": "block", "tissue": {"voxel_mm": 0.05, "solids": [
  {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -3.5], "size_mm": [12, 10, 3]}}},
  {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, -1], "size_mm": [12, 10, 2]}}}]},
  "tools": ["round_012", "cylinder_012", "flame_018", "round_040"]})";

/// Cuts strokes that consist of parallel passes straight through the tissue.
struct Cutter {
  haptics::Carver& carver;
  dvec3 low, high;  // m, frame W: least and greatest coordinates of the tissue
  Nanos t = 0;

  /// Makes one stroke with the tool of index `tool`: `passes` parallel passes at a distance of `apart` (m), with the
  /// centre of the tool's head at the height `z` (m).
  void stroke(std::uint32_t tool, int passes, double apart, double z) {
    t += kNanosPerSecond;
    const double middle = 0.5 * (low.y + high.y);
    for (int pass = 0; pass < passes; ++pass) {
      const double y = middle + apart * (pass - 0.5 * passes);
      for (double x = low.x; x < high.x; x += 0.1e-3) {
        Cut cut;
        cut.index = carver.cuts() + 1, cut.t = t += 1'000'000, cut.tool = tool;
        cut.X_WA.p = {x, y, z}, cut.X_WB.p = {x + 0.1e-3, y, z};
        carver.apply(cut);
      }
    }
  }
};

/// Adds the rows of one kind of stroke. The stroke is repeated `repeats` times, each time at another height.
template <typename Height>
void measure(std::vector<BenchRow>& rows, Cutter& cutter, std::uint32_t tool, int passes, double apart, int repeats,
             const Height& z, const std::string& knob) {
  haptics::Carver& carver = cutter.carver;
  std::vector<double> rest, back, again;
  std::size_t bytes = 0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    cutter.stroke(tool, passes, apart, z(repeat));
    const Nanos ended = thread_cpu_time();
    carver.rest(cutter.t + kNanosPerSecond);
    const Nanos start = thread_cpu_time();
    rest.push_back(static_cast<double>(start - ended));
    carver.undo();
    const Nanos undone = thread_cpu_time();
    carver.redo();
    again.push_back(static_cast<double>(thread_cpu_time() - undone));
    back.push_back(static_cast<double>(undone - start));
    (void)carver.volume().take_changed_bricks();
    // bytes that are stored for undoing this stroke alone; the data of the previous stroke were discarded
    bytes = carver.volume().strokes().bytes;
    carver.undo();  // reverts the stroke, so that the next stroke cuts the same tissue
  }
  const double kilobytes = static_cast<double>(bytes) / 1024;
  rows.push_back({.name = "prepared in the pause after it",
                  .knob = knob,
                  .time_ns = quantile(rest, 0.5),
                  .per = "stroke",
                  .size = kilobytes,
                  .size_unit = "kB kept"});
  rows.push_back({.name = "undo",
                  .knob = knob,
                  .time_ns = quantile(back, 0.5),
                  .per = "stroke",
                  .size = kilobytes,
                  .size_unit = "kB kept"});
  rows.push_back({.name = "redo",
                  .knob = knob,
                  .time_ns = quantile(again, 0.5),
                  .per = "stroke",
                  .size = kilobytes,
                  .size_unit = "kB kept"});
}

Cutter cutter_of(haptics::Carver& carver) {
  glm::ivec3 lo, hi;
  carver.volume().bounds(lo, hi);
  const VoxelFrame frame = carver.volume().frame();
  return {carver, frame.to_world(dvec3(lo)), frame.to_world(dvec3(hi))};
}

}  // namespace

std::vector<BenchRow> bench_undo(const BenchRun& run) {
  std::vector<BenchRow> rows;
  {
    const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
    haptics::Carver carver(load_tissue(scene), haptics::tool_set(scene.servo));
    Cutter cutter = cutter_of(carver);
    for (const int passes : {1, 4, 16})  // strokes go through the crown, below its top
      measure(
          rows, cutter, 0, passes, 0.2e-3, run.quick ? 3 : 15,
          [&](int repeat) { return cutter.high.z - 2.5e-3 - 0.1e-3 * repeat; },
          fmt::format("{} passes through the crown", passes));
  }
  const Scene scene = parse_scene(Json::parse(kBlock, "block"), assets_folder() / "scenes/block.json");
  const std::span<const haptics::Tool> tools = haptics::tool_set(scene.servo);
  haptics::Carver carver(load_tissue(scene), tools);
  Cutter cutter = cutter_of(carver);
  for (std::uint32_t tool = 0; tool < tools.size(); ++tool)
    for (const int passes : {4, 16})
      measure(
          rows, cutter, tool, passes, 0.4 * tools[tool].diameter, run.quick ? 1 : 5,
          [&](int repeat) { return -0.1e-3 * repeat; },
          fmt::format("{} passes of {} at h = 0.05 mm", passes, tools[tool].name));
  return rows;
}

}  // namespace typodont
