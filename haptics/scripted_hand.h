// A hand without hardware: a path from a CSV file, or a simulated hand (mass, damper, spring, tremor) that a path
// pulls.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// The path of a tool: docs/interface.md, "Hand (CSV)", limited to kLongestSession. Interpolated linearly and by slerp
/// between rows; before the first and after the last row the pose is constant.
struct HandPath {
  struct Row {
    double t = 0;  // s
    Pose X_WT;
    double pedal = 0;
    dvec3 push{0};           // N, additional force on a simulated hand
    std::uint32_t tool = 0;  // index of the wanted tool from this row on
  };
  std::vector<Row> rows;  // `t` strictly increasing, at least one row

  double end() const { return rows.back().t; }
  Row at(double t) const noexcept;
};
/// Reads the path of a hand. `tools`: names of the tools for the optional column "tool"; the column may also contain
/// indices into this list. Throws Error with file, line and column.
HandPath read_hand_path(const std::filesystem::path& csv, const std::vector<std::string>& tools = {});

/// A simulated hand: m·a = K (x_path − x) + b (v_path − v) + push + F_device. Orientation and pedal follow the path
/// exactly.
struct HandModel {
  double mass = 0.15;           // kg
  double damping = 5;           // N·s/m
  dvec3 stiffness{0};           // N/m
  dvec3 push{0};                // N
  double tremor_amplitude = 0;  // N, amplitude of a sinusoidal force on each axis (physiological tremor, 8–12 Hz)
  double tremor_frequency = 9;  // Hz
};

/// Opens the hand of --hand: HAND.csv is followed exactly, HAND.json moves by its HandModel. `paced`: waits for each
/// sample's time on the clock; otherwise the same samples come as fast as possible. Throws Error.
std::unique_ptr<HapticDevice> open_scripted_hand(const std::filesystem::path& file, double rate, bool paced,
                                                 const std::vector<std::string>& tools = {});
/// Duration of the hand that open_scripted_hand() opens, s. Throws Error.
double length_of_scripted_hand(const std::filesystem::path& file, const std::vector<std::string>& tools = {});
/// Constructs scripted and simulated hands from values, for programs that compute their own path.
std::unique_ptr<HapticDevice> make_scripted_hand(HandPath path, double rate, bool paced);
std::unique_ptr<HapticDevice> make_simulated_hand(HandPath path, const HandModel& model, double rate, bool paced);

}  // namespace typodont::haptics
