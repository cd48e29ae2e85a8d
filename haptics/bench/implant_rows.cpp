// Measures ticks of the model `implant` (paper S1 in docs/papers.md), without contact and in a bed (the drilled hole).
// The tool has voxels of 0.06 mm.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench/scene.h"
#include "haptics/bench/timing.h"
#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/implant/implant_model.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/implant_bench.h"
#include "haptics/implant_tool.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"

namespace typodont::haptics {

namespace {

using namespace implant;

/// Makes cancellous bone under 2 mm of cortical bone, with the surface at z = 0. `bed_mm` is the depth of a bed
/// (drilled hole) with a diameter of 4.2 mm around the z axis; 0 means no bed.
DenseTissue bone(double bed_mm) {
  const auto bored = [&](const std::string& box) {
    return bed_mm > 0 ? fmt::format(R"({{"difference": [{}, {{"cylinder": {{"radius_mm": 2.1, "height_mm": {}}}}}]}})",
                                    box, 2 * bed_mm)
                      : box;
  };
  return read_solids(Json::parse(fmt::format(
                                     R"({{"voxel_mm": 0.15, "solids": [
      {{"tissue": "cancellous_bone", "hardness": 0.8, "solid": {}}}, {{"tissue": "cortical_bone", "solid": {}}}]}})",
                                     bored(R"({"box": {"center_mm": [0, 0, -8], "size_mm": [12, 12, 16]}})"),
                                     bored(R"({"box": {"center_mm": [0, 0, -1], "size_mm": [12, 12, 2]}})")),
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

Tool tap() {
  return read_tool(Json::parse(
      R"({"name": "tap 4.8 mm", "shape": "cylinder", "diameter_mm": 4.8, "length_mm": 12, "implant": {"kind": "tap",
          "thread": {"pitch_mm": 0.8, "core_mm": 4.2}, "top_speed_rpm": 15}})",
      "bench"));
}

struct Case {
  const char* name;
  Tool tool;
  double pedal;
  double bed_mm;  // mm, depth of the bed (drilled hole) at the start; 0 if there is none
  Motion state;   // state of the contact that the hand's motion must produce, for example drilling
  // returns the position of the head's centre in tick `tick`, in m. `last`: result of the last tick; `half`: m, half
  // the length of the head.
  dvec3 (*hand)(int tick, const ServoTick& last, double half);
};

std::vector<double> times_of(const Case& now, int count) {
  ServoSettings settings;
  settings.tool = now.tool;
  settings.stiffness = 3000;
  settings.spindle.free_speed = 0.8 * kKrpm;
  for (Material& m : settings.materials) m.specific_energy = 0.5e9;
  settings.method = implant::read(std::nullopt);
  if (now.bed_mm > 0) {
    settings.method = implant::read(Json::parse(
        fmt::format(
            R"({{"beds": [{{"entry_mm": [0, 0, 0], "axis": [0, 0, -1], "depth_mm": {}, "diameter_mm": 4.2}}]}})",
            now.bed_mm),
        "bench"));
  }
  const double half = now.tool.half();
  std::uint32_t state = 0;
  std::vector<double> times = bench::least_of([&] {
    return bench::servo_times(TissueVolume(bone(now.bed_mm)), settings, now.pedal, count, [&](int i, ServoTick& last) {
      if (i == 0) last.X_WG.p = {0, 0, half + 0.05e-3};
      state = last.level;
      return now.hand(i, last, half);
    });
  });
  if (state != static_cast<std::uint32_t>(now.state))
    throw RunFailure(fmt::format("bench implant: \"{}\" ended in state {}", now.name, state));
  return times;
}

}  // namespace

std::vector<BenchRow> bench_implant(bool quick) {
  const Parameters usual;
  std::vector<BenchRow> rows;
  const Case cases[] = {
      {"free, a drill that slides on the bone", drill(), 0, 0, Motion::kFree,
       [](int i, const ServoTick&, double half) {
         return dvec3(1e-3 * std::sin(0.003 * i), 0, half - std::min(0.5e-3, 2e-6 * i));
       }},
      {"free, a round bur that cuts", round(), 1, 0, Motion::kFree,
       [](int i, const ServoTick&, double half) {
         return dvec3(2e-3 * std::sin(0.003 * i), 0, half - std::min(0.5e-3, 1e-6 * i));
       }},
      {"in a bed, a drill that deepens it", drill(), 1, 0, Motion::kDrilling,
       [](int, const ServoTick& last, double) { return last.X_WG.p - dvec3(0, 0, 0.7e-3); }},
      {"in a bed of 8 mm, a drill that deepens it", drill(), 1, 8, Motion::kDrilling,
       [](int i, const ServoTick& last, double half) {
         return (i == 0 ? dvec3(0, 0, half - 7.95e-3) : last.X_WG.p) - dvec3(0, 0, 0.7e-3);
       }},
      {"in a bed, a drill that slides", drill(), 0, 8, Motion::kSliding,
       [](int i, const ServoTick&, double half) { return dvec3(0, 0, half - 7e-3 - 0.9e-3 * std::sin(0.003 * i)); }},
      {"in a bed, a tap that cuts a thread", tap(), 1, 10, Motion::kScrewing,
       [](int i, const ServoTick& last, double half) {
         return i == 0 ? dvec3(0, 0, half - 6e-3) : last.X_WG.p - dvec3(0, 0, 0.3e-3);
       }},
  };
  const int count = quick ? 1000 : 5000;
  for (const Case& now : cases) {
    const ToolVoxels voxels = make_tool_voxels(now.tool, usual.tool_voxel, usual.layers);
    const std::vector<double> times = times_of(now, count);
    const std::string knob = fmt::format("{}, {} outer voxels", now.tool.name, voxels.outer.size());
    const auto add = [&](const char* which, double q) {
      rows.push_back({fmt::format("{}, {}", now.name, which), knob, BenchRow::kNone, "", quantile(times, q), "tick", "",
                      BenchRow::kNone, static_cast<double>(voxels.outer.size()), "voxels"});
    };
    add("median", 0.5);
    add("99.9 %", 0.999);
  }
  return rows;
}

}  // namespace typodont::haptics
