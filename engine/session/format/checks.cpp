#include "engine/session/format/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"

namespace typodont::session {

namespace {

constexpr RecordingLimits kLimits = kRecordingLimits;
constexpr double kUnitTolerance = 1e-3;  // largest deviation of a unit quaternion's or vector's length from 1

/// A row of a table, for messages. `what`: the column.
struct Row {
  const std::string& file;
  std::string_view table;
  std::uint64_t number;

  [[noreturn]] void fail(std::string_view what, const std::string& found, const std::string& expected) const {
    throw Error(file, fmt::format("{}, row {}, {}", table, number, what), found, expected);
  }
  void within(std::string_view what, double value, double least, double most) const {
    if (!(value >= least && value <= most))
      fail(what, fmt::format("{:g}", value), fmt::format("{:g} to {:g}", least, most));
  }
  void time(Nanos t) const {
    if (t < -kLimits.longest || t > kLimits.longest)
      fail("t_ns", std::to_string(t), fmt::format("at most {} days", kLimits.longest / (86'400 * kNanosPerSecond)));
  }
  void vector(std::string_view what, const dvec3& v, double most) const {
    for (int i = 0; i < 3; ++i) within(what, v[i], -most, most);
  }
  void pose(std::string_view what, const Pose& X, double farthest) const {
    vector(what, X.p, farthest);
    const double norm = glm::length(X.R);
    if (!(std::abs(norm - 1) <= kUnitTolerance))
      fail(what, fmt::format("a quaternion of length {:g}", norm), "a unit quaternion");
  }
  void volumes(std::string_view what, const PerTissue& volumes) const {
    for (const double v : volumes) within(what, v, -kLimits.max_volume, kLimits.max_volume);
  }
  void tool(std::uint32_t tool, std::size_t tools) const {
    if (tool >= tools) fail("tool", std::to_string(tool), fmt::format("one of the session's {} tools", tools));
  }
  template <class T>
  void after(std::string_view what, T value, T before, bool or_equal = false) const {
    if (value < before || (value == before && !or_equal))
      fail(what, std::to_string(value), fmt::format("{} {}", or_equal ? "at least" : "above", before));
  }
};

}  // namespace

void check_header(const std::string& file, const SessionHeader& header) {
  const auto within = [&](const char* what, double value, double least, double most) {
    if (!(value >= least && value <= most))
      throw Error(file, what, fmt::format("{:g}", value), fmt::format("{:g} to {:g}", least, most));
  };
  within("servo_rate_Hz", header.servo_rate, kLimits.lowest_rate, kLimits.highest_rate);
  within("voxel_mm", header.voxel * 1e3, 0, 10);
  for (const double v : header.volumes_before)
    within("header/volumes_before_mm3", v * 1e9, 0, kLimits.max_volume * 1e9);
}

void check_ticks(const std::string& file, std::span<const ServoTick> ticks, std::uint64_t first, std::size_t tools) {
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const ServoTick& tick = ticks[i];
    const Row row{file, "ticks", first + i};
    if (i > 0) row.after("index", tick.index, ticks[i - 1].index);
    row.time(tick.t);
    row.pose("tool_*", tick.X_WG, kLimits.farthest);
    row.vector("force_*_N", tick.f_T_W, kLimits.max_force);
    row.vector("torque_*_Nmm", tick.tau_T_W, kLimits.max_force);
    row.vector("normal_*", tick.n_C_W, 1 + kUnitTolerance);
    row.within("contact_area_mm2", tick.contact_area * 1e6, 0, 1e6);
    row.volumes("removed_*_mm3", tick.removed);
    row.within("spindle_krpm", std::abs(tick.spindle), 0, kLimits.fastest_spindle);
    row.within("cutting_power_W", tick.cutting_power, -1e6, 1e6);
    row.within("energy_mJ", tick.energy, -1e6, 1e6);
    row.within("wear", tick.wear, 0, 1e6);
    row.tool(tick.tool, tools);
  }
}

void check_cuts(const std::string& file, std::span<const Cut> cuts, std::size_t tools) {
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const Cut& cut = cuts[i];
    const Row row{file, "cuts", i};
    row.after("index", cut.index, i > 0 ? cuts[i - 1].index : 0);
    row.after("tick", cut.tick, i > 0 ? cuts[i - 1].tick : 0, /*or_equal=*/true);
    row.time(cut.t);
    row.pose("a_*", cut.X_WA, kLimits.farthest_cut);
    row.pose("b_*", cut.X_WB, kLimits.farthest_cut);
    row.within("from a to b, m", glm::length(cut.X_WB.p - cut.X_WA.p), 0, kLimits.longest_cut);
    row.tool(cut.tool, tools);
    row.volumes("removed_*_m3", cut.removed);
    row.vector("normal_*", cut.n_C_W, 1 + kUnitTolerance);
    row.within("spindle_rad_per_s", std::abs(cut.spindle), 0, kLimits.fastest_spindle);
    row.within("fill_radius_m", cut.fill_radius, 0, kLimits.max_fill);
  }
}

void check_patches(const std::string& file, std::span<const PatchUse> patches) {
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const PatchUse& patch = patches[i];
    const PatchUse before = i > 0 ? patches[i - 1] : PatchUse{};
    const Row row{file, "patches", i};
    row.after("patch", patch.patch, before.patch);
    row.after("first_tick", patch.first_tick, before.first_tick, /*or_equal=*/true);
    row.after("cuts", patch.cuts, before.cuts, /*or_equal=*/true);
    row.vector("center_*_m", patch.center_W, kLimits.farthest);
  }
}

void check_times(const std::string& file, const std::string& table, std::span<const Nanos> times) {
  for (std::size_t i = 0; i < times.size(); ++i) Row{file, table, i}.time(times[i]);
}

}  // namespace typodont::session
