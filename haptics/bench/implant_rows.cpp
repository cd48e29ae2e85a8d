// Implant surgery (paper S1 in docs/papers.md): ticks of the model `implant` in both states, with tool voxels of 0.06
// mm.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench/scene.h"
#include "haptics/bench/timing.h"
#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/implant_bench.h"
#include "haptics/implant_tool.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"

namespace typodont::haptics {

namespace {

using namespace implant;

/// Cancellous bone below 2 mm of cortical bone; the surface is at z = 0.
DenseTissue bone() {
  return read_solids(Json::parse(R"({"voxel_mm": 0.15, "solids": [
      {"tissue": "cancellous_bone", "hardness": 0.8, "solid": {"box": {"center_mm": [0, 0, -8], "size_mm": [12, 12, 16]}}},
      {"tissue": "cortical_bone", "solid": {"box": {"center_mm": [0, 0, -1], "size_mm": [12, 12, 2]}}}]})",
                                 "bench"));
}

Tool drill() {
  return read_tool(Json::parse(
      R"({"name": "drill 4.2 mm", "shape": "cylinder", "diameter_mm": 4.2, "length_mm": 12, "implant": {"kind": "drill",
          "ability": {"end": 1, "centre": 1}, "thrust_ratio": 12, "speed_rpm": 400}})",
      "bench"));
}
Tool round() {
  return read_tool(Json::parse(
      R"({"name": "round 3.3 mm", "shape": "sphere", "diameter_mm": 3.3, "implant": {"kind": "round",
          "ability": {"end": 1, "side": 1}, "thrust_ratio": 12, "speed_rpm": 800}})",
      "bench"));
}

struct Motion {
  const char* name;
  Tool tool;
  double pedal;
  dvec3 (*hand)(int tick, const ServoTick& last, double half);  // returns the position of the head's centre, m
};

std::vector<double> times_of(const Motion& motion, int count) {
  ServoSettings settings;
  settings.tool = motion.tool;
  settings.stiffness = 3000;
  settings.spindle.free_speed = 0.8 * kKrpm;
  for (Material& m : settings.materials) m.specific_energy = 0.5e9;
  settings.method = implant::read(std::nullopt);
  const double half = motion.tool.half();
  return bench::least_of([&] {
    return bench::servo_times(TissueVolume(bone()), settings, motion.pedal, count, [&](int i, ServoTick& last) {
      if (i == 0) last.X_WG.p = {0, 0, half + 0.05e-3};
      return motion.hand(i, last, half);
    });
  });
}

}  // namespace

std::vector<BenchRow> bench_implant(bool quick) {
  const Parameters usual;
  std::vector<BenchRow> rows;
  const Motion motions[] = {
      {"free, a drill that slides on the bone", drill(), 0,
       [](int i, const ServoTick&, double half) {
         return dvec3(1e-3 * std::sin(0.003 * i), 0, half - std::min(0.5e-3, 2e-6 * i));
       }},
      {"free, a round bur that cuts", round(), 1,
       [](int i, const ServoTick&, double half) {
         return dvec3(2e-3 * std::sin(0.003 * i), 0, half - std::min(0.5e-3, 1e-6 * i));
       }},
      {"in a bed, a drill that deepens it", drill(), 1,
       [](int, const ServoTick& last, double) { return last.X_WG.p - dvec3(0, 0, 0.7e-3); }},
  };
  const int count = quick ? 1000 : 5000;
  for (const Motion& motion : motions) {
    const ToolVoxels voxels = make_tool_voxels(motion.tool, usual.tool_voxel, usual.layers);
    const std::vector<double> times = times_of(motion, count);
    const std::string knob = fmt::format("{}, {} outer voxels", motion.tool.name, voxels.outer.size());
    const auto add = [&](const char* which, double q) {
      rows.push_back({fmt::format("{}, {}", motion.name, which), knob, BenchRow::kNone, "", quantile(times, q), "tick",
                      "", BenchRow::kNone, static_cast<double>(voxels.outer.size()), "voxels"});
    };
    add("median", 0.5);
    add("99.9 %", 0.999);
  }
  return rows;
}

}  // namespace typodont::haptics
