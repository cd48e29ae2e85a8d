#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "audio/contact_track.h"
#include "audio/tick_voice.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::audio {

namespace {

const std::vector<std::string> kContactColumns = {
    "spindle_krpm",  "pedal",   "force_N", "contact_area_mm2", "removal_mm3_per_s", "tissue",
    "slip_mm_per_s", "suction", "spray",   "cutting"};
const std::vector<std::string> kTickColumns = {
    "spindle_krpm", "contact_area_mm2", "tissue",    "force_x_N", "force_y_N", "force_z_N", "removed_mm3",
    "tool_x_mm",    "tool_y_mm",        "tool_z_mm", "normal_x",  "normal_y",  "normal_z"};

double read_tissue(std::string_view cell) {
  if (const auto tissue = tissue_named(cell)) return static_cast<double>(*tissue);
  if (cell == "none" || cell.empty()) return 0;
  double number = -1;
  const auto result = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  const bool valid = result.ec == std::errc() && result.ptr == cell.data() + cell.size() && number >= 0 &&
                     number < kTissueCount && number == std::floor(number);
  return valid ? number : std::numeric_limits<double>::quiet_NaN();
}

double ignored(std::string_view) {
  return 0;
}

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

ContactTrack read_contact_track(const std::filesystem::path& file) {
  // Any column named below marks a file of ticks, which may also have unknown columns; a file of contacts must not.
  const auto header = csv_columns(file);
  const bool ticks = among(header, "removed_mm3") || among(header, "force_x_N") || among(header, "hand_x_mm");
  std::map<std::string, CellReader> readers = {
      {"tissue",
       {&read_tissue, fmt::format("a tissue's name (air, enamel, dentin …) or number 0 to {}", kTissueCount - 1)}}};
  std::vector<std::string> optional = kContactColumns;
  if (ticks) {
    optional.insert(optional.end(), kTickColumns.begin(), kTickColumns.end());
    for (const auto& name : header) {
      if (name == "t_s" || among(optional, name)) continue;
      readers[name] = {&ignored, ""};
      optional.push_back(name);
    }
  } else {
    for (const auto& name : header) {
      if (name == "t_s" || among(optional, name)) continue;
      throw Error(file.string(), "header", fmt::format("column \"{}\"", name.substr(0, 40)),
                  fmt::format("t_s and any of {}", fmt::join(kContactColumns, ", ")));
    }
  }
  const CsvTable table = read_csv(file, {"t_s"}, optional, readers);
  if (table.rows.empty()) throw Error(file.string(), "", "no rows", "at least one");

  const auto value = [&](std::size_t row, const char* name, double fallback, double low, double high) {
    const double v = table.value(row, name);
    if (std::isnan(v)) return fallback;
    if (v < low || v > high) table.fail(row, name, fmt::format("{}", v), fmt::format("{} to {}", low, high));
    return v;
  };
  const auto vector = [&](std::size_t row, const char* x, const char* y, const char* z) {
    return dvec3(value(row, x, 0, -1e6, 1e6), value(row, y, 0, -1e6, 1e6), value(row, z, 0, -1e6, 1e6));
  };
  const bool has_area = table.column("contact_area_mm2") >= 0;
  const bool has_removed = table.column("removed_mm3") >= 0, has_position = table.column("tool_x_mm") >= 0;
  const bool has_force = table.column("force_N") >= 0, has_tissue = table.column("tissue") >= 0;

  ContactTrack track;
  track.has_spindle = table.column("spindle_krpm") >= 0;
  double before = -1;
  std::size_t back = 0;  // index of an earlier row, from which differences are computed
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const double t = value(row, "t_s", 0, 0, 1e6);
    if (t <= before) table.fail(row, "t_s", fmt::format("{} after {}", t, before), "times that increase");
    before = t;
    const auto time_of = [&](std::size_t r) { return value(r, "t_s", 0, 0, 1e6); };
    while (back + 1 < row && time_of(back + 1) <= t - to_seconds(TickVoice::kDifferenceOver)) ++back;
    const double elapsed = row > 0 ? t - time_of(back) : 0.0;

    SoundState state;
    state.t = from_seconds(t);
    state.spindle = std::abs(value(row, "spindle_krpm", 0, -2000, 2000)) * kKrpm;
    state.pedal = value(row, "pedal", 1, 0, 1);
    state.contact_area = value(row, "contact_area_mm2", 0, 0, 1e6) * kSquareMillimetre;
    state.force =
        has_force ? value(row, "force_N", 0, 0, 1e6) : glm::length(vector(row, "force_x_N", "force_y_N", "force_z_N"));
    state.removal_rate = value(row, "removal_mm3_per_s", 0, 0, 1e6) * kCubicMillimetre;
    if (has_removed && elapsed > 0) {
      const double cut = value(row, "removed_mm3", 0, 0, 1e9) - value(back, "removed_mm3", 0, 0, 1e9);
      state.removal_rate = std::max(0.0, cut / elapsed) * kCubicMillimetre;
    }
    state.slip_speed = value(row, "slip_mm_per_s", 0, 0, 1e6) * kMillimetre;
    if (has_position && elapsed > 0) {
      const dvec3 n = vector(row, "normal_x", "normal_y", "normal_z");
      const dvec3 v =
          (vector(row, "tool_x_mm", "tool_y_mm", "tool_z_mm") - vector(back, "tool_x_mm", "tool_y_mm", "tool_z_mm")) /
          elapsed;
      state.slip_speed = glm::length(v - n * glm::dot(v, n)) * kMillimetre;
    }
    // Force without contact comes from inertia and damping, which are silent.
    if (has_area && state.contact_area == 0 && state.removal_rate == 0) state.force = 0;
    state.tissue = static_cast<Tissue>(static_cast<int>(value(row, "tissue", 0, 0, kTissueCount - 1)));
    if (!has_tissue) state.tissue = Tissue::kEnamel;
    state.suction = value(row, "suction", 0, 0, 1);
    state.spray = value(row, "spray", 0, 0, 1);
    state.cutting_tool = value(row, "cutting", 1, 0, 1) > 0.5;
    track.fastest = std::max(track.fastest, state.spindle);
    track.states.push_back(state);
  }
  track.end = before;
  return track;
}

std::optional<SoundState> VoicedTrack::next() noexcept {
  // Air turbine: stall torque 2.33 N·mm at most (measured), bur of 1.2 mm diameter, friction coefficient 0.4 at its
  // rim.
  constexpr double kStallTorque = 2.33e-3, kRim = 0.6e-3, kFriction = 0.4;
  constexpr Nanos kStep = kNanosPerSecond / 1000;
  if (row_ == track_.states.size()) return std::nullopt;
  const SoundState& a = track_.states[row_];
  SoundState state = a;
  state.t += after_;
  const bool last = row_ + 1 == track_.states.size();
  if (!last) {
    const SoundState& b = track_.states[row_ + 1];
    const double w = static_cast<double>(after_) / static_cast<double>(b.t - a.t);
    for (const auto field :
         {&SoundState::spindle, &SoundState::pedal, &SoundState::contact_area, &SoundState::force,
          &SoundState::removal_rate, &SoundState::slip_speed, &SoundState::suction, &SoundState::spray}) {
      if (after_ > 0) state.*field = (1 - w) * a.*field + w * b.*field;
    }
    after_ += kStep;
  }
  if (last || a.t + after_ >= track_.states[row_ + 1].t) {
    ++row_;
    after_ = 0;
  }
  if (!track_.has_spindle) {
    const double torque = kFriction * kRim * state.force;
    state.spindle =
        state.pedal > 0 && state.cutting_tool ? free_speed_ * std::max(0.0, 1 - torque / kStallTorque) : 0.0;
  }
  return state;
}

}  // namespace typodont::audio
