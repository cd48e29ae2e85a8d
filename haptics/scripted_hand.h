// A hand without hardware. It either follows a path from a CSV file, or is simulated: a path pulls a mass with damper,
// spring and tremor.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// The path of a tool (format: docs/interface.md, "Hand (CSV)"), not longer than kLongestSession. Between rows,
/// positions are interpolated linearly and orientations by slerp. Before the first row and after the last row the pose
/// is constant.
struct HandPath {
  struct Row {
    double t = 0;  // s, time
    Pose X_WT;
    double pedal = 0;
    dvec3 push{0};           // N, additional force on a simulated hand
    std::uint32_t tool = 0;  // index of the tool that the hand wants from this row on
  };
  std::vector<Row> rows;  // at least one row; `t` strictly increases

  double end() const { return rows.back().t; }
  Row at(double t) const noexcept;
};
/// Reads the path of a hand. The optional column "tool" contains names from `tools` or indices into this list. Throws
/// Error with file, line and column.
HandPath read_hand_path(const std::filesystem::path& csv, const std::vector<std::string>& tools = {});

/// Parameters of a simulated hand with the equation of motion m·a = K (x_path − x) + b (v_path − v) + push + F_device.
/// Orientation and pedal follow the path exactly.
struct HandModel {
  double mass = 0.15;  // kg, mass of the hand (m in the equation of motion)
  double damping = 5;  // N·s/m, damper between the hand and the path (b in the equation of motion)
  // N/m, spring between the hand and the path, for each axis (diagonal of K in the equation of motion)
  dvec3 stiffness{0};
  dvec3 push{0};                // N, constant additional force
  double tremor_amplitude = 0;  // N, amplitude of a sinusoidal force on each axis (physiological tremor has 8–12 Hz)
  double tremor_frequency = 9;  // Hz, frequency of the tremor
};

/// Opens a hand from a file given to --hand. A HAND.csv is followed exactly; a HAND.json is moved by its HandModel.
/// `paced`: true waits for the time of each sample; false returns the same samples as fast as possible. Throws Error.
std::unique_ptr<HapticDevice> open_scripted_hand(const std::filesystem::path& file, double rate, bool paced,
                                                 const std::vector<std::string>& tools = {});
/// Returns the duration of a hand that open_scripted_hand() can open, s. Throws Error.
double length_of_scripted_hand(const std::filesystem::path& file, const std::vector<std::string>& tools = {});
/// Constructs a scripted or simulated hand from values, for programs that compute their own path.
std::unique_ptr<HapticDevice> make_scripted_hand(HandPath path, double rate, bool paced);
std::unique_ptr<HapticDevice> make_simulated_hand(HandPath path, const HandModel& model, double rate, bool paced);

}  // namespace typodont::haptics
