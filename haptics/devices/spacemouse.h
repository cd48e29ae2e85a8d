// SpaceMouse (3Dconnexion) as a hand: controls velocity or position in six degrees of freedom; no force output.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Deflection of the cap, -1 to 1: x right, y to the user, z down.
struct SpaceMouseState {
  dvec3 push{0}, twist{0};
  std::uint32_t buttons = 0;
};
/// Updates `state` from a report. Returns false and leaves `state` unchanged if the report is unknown.
bool parse_spacemouse(std::span<const std::uint8_t> report, SpaceMouseState& state);
bool is_spacemouse(std::uint16_t vendor, std::uint16_t product);

struct SpaceMouseControl {
  bool rate_control = true;  // the cap controls the velocity; false: the position
  double speed = 0.05;       // m/s, speed at full deflection with rate control
  double turn_speed = 1.0;   // rad/s, angular speed at full deflection with rate control
  double reach = 0.03;       // m, displacement at full deflection with position control
  double turn_reach = 0.6;   // rad, rotation at full deflection with position control
  double dead_zone = 0.03;
  double smoothing = 0.02;  // s, time constant of a filter; smooths reports at 100 Hz for a servo at 1 kHz
};
/// Creates the hand. Base frame H: x right, y away, z up. Button 1 acts as the pedal.
std::unique_ptr<HapticDevice> make_spacemouse(std::unique_ptr<Link> link, const SpaceMouseControl& control, double rate,
                                              DeviceInfo identity);

}  // namespace typodont::haptics
