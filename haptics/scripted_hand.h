// Without hardware: a path from CSV, or a mass with damper, spring and tremor pulled along one.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// docs/interface.md, "Hand (CSV)"; up to kLongestSession. Linear and slerp between rows, constant outside.
struct HandPath {
  struct Row {
    double t = 0;  // s, time
    Pose X_WT;
    double pedal = 0;
    dvec3 push{0};           // N, additional force on a simulated hand
    std::uint32_t tool = 0;  // wanted from this row on
  };
  std::vector<Row> rows;  // at least one row; `t` strictly increases

  double end() const { return rows.back().t; }
  Row at(double t) const noexcept;
};
/// Column "tool": names of `tools` or indices. Throws Error with file, line and column.
HandPath read_hand_path(const std::filesystem::path& csv, const std::vector<std::string>& tools = {});

/// m·a = K (x_path − x) + b (v_path − v) + push + F_device. Orientation and pedal follow the path.
struct HandModel {
  double mass = 0.15;  // kg, m
  double damping = 5;  // N·s/m, b: hand to path
  // N/m per axis, diagonal of K
  dvec3 stiffness{0};
  dvec3 push{0};                // N, constant additional force
  double tremor_amplitude = 0;  // N per axis, sinusoidal (physiological: 8–12 Hz)
  double tremor_frequency = 9;  // Hz, frequency of the tremor
};

/// HAND.csv exactly, HAND.json by its HandModel. `paced`: waits for each sample's time. Throws Error.
std::unique_ptr<HapticDevice> open_scripted_hand(const std::filesystem::path& file, double rate, bool paced,
                                                 const std::vector<std::string>& tools = {});
/// s. Throws Error.
double length_of_scripted_hand(const std::filesystem::path& file, const std::vector<std::string>& tools = {});
/// From values, for programs with their own path.
std::unique_ptr<HapticDevice> make_scripted_hand(HandPath path, double rate, bool paced);
std::unique_ptr<HapticDevice> make_simulated_hand(HandPath path, const HandModel& model, double rate, bool paced);

}  // namespace typodont::haptics
