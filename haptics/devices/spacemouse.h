// SpaceMouse (3Dconnexion): six degrees by rate or position, no force.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// -1 to 1: x right, y to the user, z down.
struct SpaceMouseState {
  dvec3 push{0}, twist{0};
  std::uint32_t buttons = 0;
};
/// false: unknown report, `state` stays.
bool parse_spacemouse(std::span<const std::uint8_t> report, SpaceMouseState& state);
bool is_spacemouse(std::uint16_t vendor, std::uint16_t product);

struct SpaceMouseControl {
  bool rate_control = true;  // velocity; false: position
  double speed = 0.05;       // m/s, speed at full deflection with rate control
  double turn_speed = 1.0;   // rad/s, angular speed at full deflection with rate control
  double reach = 0.03;       // m, displacement at full deflection with position control
  double turn_reach = 0.6;   // rad, rotation at full deflection with position control
  double dead_zone = 0.03;
  double smoothing = 0.02;  // s; reports at 100 Hz, servo at 1 kHz
};
/// H: x right, y away, z up. Button 1: pedal.
std::unique_ptr<HapticDevice> make_spacemouse(std::unique_ptr<Link> link, const SpaceMouseControl& control, double rate,
                                              DeviceInfo identity);

}  // namespace typodont::haptics
