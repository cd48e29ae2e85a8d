#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"

namespace typodont::haptics::bench {

void histogram_rows(const std::string& name, const std::string& knob, const std::vector<double>& ticks,
                    std::vector<BenchRow>& rows) {
  const auto octave = [](double ns) { return std::max(static_cast<int>(std::floor(std::log2(ns / 1000))), -1); };
  std::map<int, int> count;
  for (const double ns : ticks) ++count[octave(ns)];
  for (const auto& [bin, in_bin] : count) {
    rows.push_back({name, fmt::format("{}, {:g} to {:g} µs", knob, bin < 0 ? 0 : std::exp2(bin), std::exp2(bin + 1)),
                    static_cast<double>(in_bin) / static_cast<double>(ticks.size()), "of the ticks",
                    1000 * std::exp2(bin + 1), "tick"});
  }
}

void drilling_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  const double voxel_mm = *std::min_element(options.voxels_mm.begin(), options.voxels_mm.end());
  const DenseTissue dense = tissue(kBlock, voxel_mm);
  double whole = 0;
  for (const double volume : TissueVolume(dense).volumes()) whole += volume;
  const std::pair<const char*, Tool> heads[] = {{"round 1.2 mm", head(HeadShape::kSphere, 1.2e-3, 1.2e-3)},
                                                {"round 4 mm", head(HeadShape::kSphere, 4e-3, 4e-3)},
                                                {"flame 1.2 x 4 mm", head(HeadShape::kFlame, 1.2e-3, 4e-3)},
                                                {"cylinder 1 x 4 mm", head(HeadShape::kCylinder, 1e-3, 4e-3)}};
  for (const auto& named : heads) {
    const Tool& tool = named.second;
    const std::string knob = fmt::format("{}, voxel {:g} mm", named.first, voxel_mm);
    ServoSettings settings;
    settings.tool = tool;
    settings.method = options.method;
    settings.spindle.free_speed = 300e3 / 60 * 2 * kPi;
    double error = 0;
    std::unique_ptr<Scene> last;
    const std::vector<double> ticks = least_of([&] {
      last = std::make_unique<Scene>(dense, settings);
      DrillingHand hand(tool);
      std::vector<double> run;
      double work = 0;
      for (int i = 0; i < options.ticks; ++i) {
        run.push_back(last->tick(hand.next(last->last.f_T_W, settings.tick), 1));
        work += last->last.cutting_power * settings.tick;
      }
      double left = 0;
      for (const double volume : last->carver.volume().volumes()) left += volume;
      // Compares two volumes: the volume that corresponds to the servo's work (work / specific energy), and the volume
      // that the carver (owner of the tissue) has removed.
      error = std::abs(work / 8e9 / (whole - left) - 1);
      return run;
    });
    Scene& scene = *last;
    const double median = quantile(ticks, 0.5);
    rows.push_back({"drilling tick, median", knob, error, "volume against energy", median, "tick"});
    for (const auto& [name, fraction] : {std::pair{"drilling tick, 99 %", 0.99}, {"drilling tick, 99.9 %", 0.999}}) {
      const double slow = quantile(ticks, fraction);
      rows.push_back({name, knob, error, "volume against energy", slow, "tick", "its median", slow / median});
    }
    histogram_rows("drilling tick, histogram", knob, ticks, rows);
    if (!by_default(options)) continue;  // the following rows measure the default model's patches (dense fields)
    const double floor = drilling_floor(dense, settings, options.ticks);
    rows.push_back(
        {"floor: the tick's cut alone, a query, a scan of the same samples", knob, BenchRow::kNone, "", floor, "tick"});
    rows.push_back({"drilling tick, median, against its floor", knob, error, "volume against energy", median, "tick",
                    "its cut, a query, a scan", median / floor});
    cut_rows(tool, knob, dense, rows);
    hand_over_rows(scene, knob, rows);
  }
}

}  // namespace typodont::haptics::bench
