#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/ticker.h"
#include "engine/base/units.h"
#include "engine/contract/session_length.h"
#include "haptics/described.h"
#include "haptics/scripted_hand.h"

namespace typodont::haptics {

namespace {

/// Index of a tool by name or number; NaN: no such tool. Without names, any number is accepted.
double tool_index(std::string_view cell, const std::vector<std::string>& tools) {
  const auto named = std::find(tools.begin(), tools.end(), cell);
  if (named != tools.end()) return static_cast<double>(named - tools.begin());
  std::uint32_t place = 0;
  const char* end = cell.data() + cell.size();
  const auto [stopped, error] = std::from_chars(cell.data(), end, place);
  const bool there = tools.empty() ? place < 1000 : place < tools.size();
  return error == std::errc() && stopped == end && there ? place : std::nan("");
}

}  // namespace

HandPath::Row HandPath::at(double t) const noexcept {
  const auto after = std::upper_bound(rows.begin(), rows.end(), t, [](double v, const Row& row) { return v < row.t; });
  if (after == rows.begin()) return rows.front();
  if (after == rows.end()) return rows.back();
  const Row& a = *(after - 1);
  const Row& b = *after;
  const double s = (t - a.t) / (b.t - a.t);
  return {t, interpolate(a.X_WT, b.X_WT, s), glm::mix(a.pedal, b.pedal, s), glm::mix(a.push, b.push, s), a.tool};
}

HandPath read_hand_path(const std::filesystem::path& csv, const std::vector<std::string>& tools) {
  const CellReader tool_reader{[&tools](std::string_view cell) { return tool_index(cell, tools); },
                               tools.empty()
                                   ? "the number of a tool, 0 being the first"
                                   : fmt::format("one of {}, or its place, 0 being the first", fmt::join(tools, ", "))};
  const CsvTable table = read_csv(csv, {"t_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "pedal"},
                                  {"push_x_N", "push_y_N", "push_z_N", "tool"}, {{"tool", tool_reader}});
  if (table.rows.empty()) throw Error(csv.string(), "", "no rows", "at least one");
  const auto index = [&](const char* name) { return table.column(name); };
  const int t = index("t_s"), x = index("x_mm"), y = index("y_mm"), z = index("z_mm"), qw = index("qw"),
            qx = index("qx"), qy = index("qy"), qz = index("qz"), pedal = index("pedal"), tool = index("tool");
  const int push[3] = {index("push_x_N"), index("push_y_N"), index("push_z_N")};
  HandPath path;
  path.chooses_tools = tool >= 0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    const auto value = [&](int column) { return row[static_cast<std::size_t>(column)]; };
    HandPath::Row out;
    out.t = value(t);
    if (!path.rows.empty() && !(out.t > path.rows.back().t)) {
      table.fail(i, "t_s", fmt::format("{}", out.t), fmt::format("more than {}", path.rows.back().t));
    }
    constexpr double kMaxStart = 60;  // s, latest time of the first row
    if (path.rows.empty() && out.t > kMaxStart) {
      table.fail(i, "t_s", fmt::format("{}", out.t),
                 fmt::format("at most {} s in the first row: times from the beginning of the session", kMaxStart));
    }
    if (out.t < 0 || out.t > kLongestSession)
      table.fail(i, "t_s", fmt::format("{}", out.t), fmt::format("0 to {} s, the longest session", kLongestSession));
    out.X_WT.p = dvec3(value(x), value(y), value(z)) * kMillimetre;
    if (glm::length(out.X_WT.p) > 10) table.fail(i, "x_mm", "a place over 10 m away", "a place on the bench");
    const dquat q(value(qw), value(qx), value(qy), value(qz));
    const double norm = glm::length(q);
    if (std::abs(norm - 1) > 0.01) table.fail(i, "qw", fmt::format("a quaternion of length {:.4g}", norm), "length 1");
    out.X_WT.R = q / norm;
    out.pedal = value(pedal);
    if (out.pedal < -1 || out.pedal > 1)
      table.fail(i, "pedal", fmt::format("{}", out.pedal), "0 to 1, or down to -1 to turn a thread back");
    for (int axis = 0; axis < 3; ++axis) {
      if (push[axis] < 0) continue;
      const double f = value(push[axis]);
      out.push[axis] = std::isfinite(f) ? f : 0;  // an empty cell means that there is no push
    }
    if (tool >= 0) out.tool = static_cast<std::uint32_t>(value(tool));
    path.rows.push_back(out);
  }
  return path;
}

namespace {

class ScriptedHand : public HapticDevice {
 public:
  ScriptedHand(HandPath path, double rate, bool paced, std::string address)
      : path_(std::move(path)), ticker_(rate, paced) {
    info_ = {std::move(address), "scripted hand", "", rate, 1e9, 0, 1e9};
    info_.chooses_tools = path_.chooses_tools;
  }
  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(HandSample& sample) noexcept override {
    const Nanos t = ticker_.next();
    if (to_seconds(t) > path_.end() + 1e-9) return false;
    const HandPath::Row row = path_.at(to_seconds(t));
    sample = {t, row.X_WT, row.pedal, row.tool};
    return true;
  }
  void write(const dvec3&, const dvec3&) noexcept override {}

 private:
  HandPath path_;
  Ticker ticker_;
  DeviceInfo info_;
};

/// Path of the motion file, relative to HAND.json.
std::filesystem::path path_of_hand(const std::filesystem::path& file, const Json& json) {
  const std::filesystem::path path = json["path"].string();
  return path.is_relative() ? file.parent_path() / path : path;
}

class SimulatedHand : public HapticDevice {
 public:
  SimulatedHand(HandPath path, const HandModel& model, double rate, bool paced, std::string address)
      : path_(std::move(path)), model_(model), rate_(rate), ticker_(rate, paced) {
    info_ = {std::move(address), "simulated hand", "", rate, 1e9, 0, 1e9};
    info_.chooses_tools = path_.chooses_tools;
    x_ = path_.rows.front().X_WT.p;
    last_path_ = x_;
  }
  const DeviceInfo& info() const noexcept override { return info_; }

  bool read(HandSample& sample) noexcept override {
    const Nanos t = ticker_.next();
    const double s = to_seconds(t);
    if (s > path_.end() + 1e-9) return false;
    const HandPath::Row row = path_.at(s);
    if (started_) {
      // Integrates in four implicit steps, stable for any stiffness and rate. The displacement uses the mean velocity,
      // so it is exact for a constant force. A stiff wall then becomes unstable exactly where theory predicts it.
      constexpr int kSubsteps = 4;
      const double dt = 1 / rate_ / kSubsteps;
      const dvec3 v_path = (row.X_WT.p - last_path_) * rate_;
      const double phase = 2 * kPi * model_.tremor_frequency * s;
      const dvec3 tremor =
          model_.tremor_amplitude * dvec3(std::sin(phase), std::sin(1.1 * phase + 1), std::sin(0.9 * phase + 2));
      for (int i = 0; i < kSubsteps; ++i) {
        const dvec3 x_path = glm::mix(last_path_, row.X_WT.p, (i + 1.0) / kSubsteps);
        const dvec3 K = model_.stiffness;
        const double b = model_.damping;
        const dvec3 f = K * (x_path - x_ - dt * v_) + b * (v_path - v_) + model_.push + row.push + tremor + force_;
        const dvec3 before = v_;
        v_ += dt * f / (model_.mass + dt * b + dt * dt * K);
        for (int axis = 0; axis < 3; ++axis)
          x_[axis] += dt * (K[axis] > 0 ? v_[axis] : 0.5 * (before[axis] + v_[axis]));
      }
    }
    started_ = true;
    last_path_ = row.X_WT.p;
    sample = {t, {x_, row.X_WT.R}, row.pedal, row.tool};
    return true;
  }
  void write(const dvec3& f_T_W, const dvec3&) noexcept override { force_ = f_T_W; }

 private:
  HandPath path_;
  HandModel model_;
  double rate_;
  Ticker ticker_;
  DeviceInfo info_;
  bool started_ = false;
  dvec3 x_{0}, v_{0}, last_path_{0}, force_{0};
};

}  // namespace

void describe_hand(Keys& keys, HandModel& model) {
  keys(must("path"), kFile, "the path, HAND.csv");
  keys("mass_kg", model.mass, {1e-4, 1000}, "mass m");
  keys("damping_Ns_per_m", model.damping, {0, 1e5}, "damping b");
  constexpr Form kStiffness{"number or [x, y, z]", R"({"type": ["number", "array"]})"};
  if (const auto k = keys("stiffness_N_per_m", kStiffness, "stiffness K; default 0")) {
    model.stiffness = k->is_array() ? k->vec3() : dvec3(k->number(0));
    if (model.stiffness.x < 0 || model.stiffness.y < 0 || model.stiffness.z < 0) k->fail("no negative stiffness");
  }
  keys("push_N", model.push, 1.0, "constant push");
  const auto tremor = [&](Keys& of) {
    of(must("amplitude_N"), model.tremor_amplitude, {0, 100}, "amplitude on each axis");
    of("frequency_Hz", model.tremor_frequency, {0.1, 1000}, "frequency");
  };
  keys("tremor", tremor, "sinusoidal tremor");
}

std::unique_ptr<HapticDevice> make_scripted_hand(HandPath path, double rate, bool paced) {
  return std::make_unique<ScriptedHand>(std::move(path), rate, paced, "script:");
}

std::unique_ptr<HapticDevice> make_simulated_hand(HandPath path, const HandModel& model, double rate, bool paced) {
  return std::make_unique<SimulatedHand>(std::move(path), model, rate, paced, "script:");
}

double length_of_scripted_hand(const std::filesystem::path& file, const std::vector<std::string>& tools) {
  return read_hand_path(file.extension() == ".json" ? path_of_hand(file, Json::load(file)) : file, tools).end();
}

std::unique_ptr<HapticDevice> open_scripted_hand(const std::filesystem::path& file, double rate, bool paced,
                                                 const std::vector<std::string>& tools) {
  const std::string address = "script:" + file.string();
  if (file.extension() != ".json")
    return std::make_unique<ScriptedHand>(read_hand_path(file, tools), rate, paced, address);
  const Json json = Json::load(file);
  const HandModel model = read_keys(json, describe_hand);
  return std::make_unique<SimulatedHand>(read_hand_path(path_of_hand(file, json), tools), model, rate, paced, address);
}

}  // namespace typodont::haptics
