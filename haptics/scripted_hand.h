// Hands without hardware: a scripted hand follows a path from a CSV file exactly; a simulated hand is a mass that
// spring and damper pull along a path, with tremor.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Path of a hand (docs/interface.md, "Hand (CSV)"), up to kLongestSession long. Interpolated between rows
/// (orientations by slerp), constant outside.
struct HandPath {
  struct Row {
    double t = 0;  // s, time
    Pose X_WT;
    double pedal = 0;
    dvec3 push{0};           // N, additional force on a simulated hand
    std::uint32_t tool = 0;  // index of the tool that is wanted from this row on
  };
  std::vector<Row> rows;       // at least one row; `t` strictly increases
  bool chooses_tools = false;  // true: the rows name tools

  double end() const { return rows.back().t; }
  Row at(double t) const noexcept;
};
/// Reads a path. Its column "tool" contains names of `tools` or indices. Throws Error with file, line and column.
HandPath read_hand_path(const std::filesystem::path& csv, const std::vector<std::string>& tools = {});

/// Simulated hand: m·a = K (x_path − x) + b (v_path − v) + push + F_device. Orientation and pedal follow the path
/// exactly.
struct HandModel {
  double mass = 0.15;  // kg, mass of the hand
  double damping = 5;  // N·s/m, damping b in the formula
  // Stiffness K in the formula, for each axis, N/m.
  dvec3 stiffness{0};
  dvec3 push{0};                // N, constant additional force
  double tremor_amplitude = 0;  // N for each axis, amplitude of the sinusoidal tremor (physiological: 8–12 Hz)
  double tremor_frequency = 9;  // Hz, frequency of the tremor
};

/// Opens HAND.csv, whose path is followed exactly, or HAND.json, which contains a HandModel. `paced`: read() waits
/// until the time of each sample. Throws Error.
std::unique_ptr<HapticDevice> open_scripted_hand(const std::filesystem::path& file, double rate, bool paced,
                                                 const std::vector<std::string>& tools = {});
/// Returns the duration of the script, s. Throws Error.
double length_of_scripted_hand(const std::filesystem::path& file, const std::vector<std::string>& tools = {});
/// Creates hands from a path in memory.
std::unique_ptr<HapticDevice> make_scripted_hand(HandPath path, double rate, bool paced);
std::unique_ptr<HapticDevice> make_simulated_hand(HandPath path, const HandModel& model, double rate, bool paced);

}  // namespace typodont::haptics
