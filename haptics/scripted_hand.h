// A hand without hardware: a path from a CSV file, or a simulated hand (mass, damper, spring, tremor) pulled along one.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// The path of a tool as held: INTERFACE.md, "Hand (CSV)", within kLongestSession. Linear and slerp between rows;
/// before the first and after the last row the pose stays.
struct HandPath {
  struct Row {
    double t = 0;  // s
    Pose X_WT;
    double pedal = 0;
    dvec3 push{0};           // N, of a simulated hand
    std::uint32_t tool = 0;  // wanted from this row on
  };
  std::vector<Row> rows;  // t strictly rising, at least one

  double end() const { return rows.back().t; }
  Row at(double t) const noexcept;
};
/// `tools`: what the tools of the optional column "tool" are called; their place there is a name, too. Throws Error
/// naming file, line, column.
HandPath read_hand_path(const std::filesystem::path& csv, const std::vector<std::string>& tools = {});

/// m·a = K (x_path − x) + b (v_path − v) + push + F_device; the orientation and the pedal follow the path.
struct HandModel {
  double mass = 0.15;           // kg
  double damping = 5;           // N·s/m
  dvec3 stiffness{0};           // N/m
  dvec3 push{0};                // N
  double tremor_amplitude = 0;  // N, of a sinusoid on each axis (physiological tremor, 8–12 Hz)
  double tremor_frequency = 9;  // Hz
};

/// From --hand: HAND.csv is followed exactly, HAND.json moves by its HandModel. `paced`: wait for each sample's time on
/// the clock; otherwise as fast as it can, with the same samples. Throws Error.
std::unique_ptr<HapticDevice> open_scripted_hand(const std::filesystem::path& file, double rate, bool paced,
                                                 const std::vector<std::string>& tools = {});
/// s, of what open_scripted_hand() opens. Throws Error.
double length_of_scripted_hand(const std::filesystem::path& file, const std::vector<std::string>& tools = {});
/// The same from values, for programs that plan their own path.
std::unique_ptr<HapticDevice> make_scripted_hand(HandPath path, double rate, bool paced);
std::unique_ptr<HapticDevice> make_simulated_hand(HandPath path, const HandModel& model, double rate, bool paced);

}  // namespace typodont::haptics
