// The SpaceMouse (3Dconnexion). It controls the tool in six degrees of freedom, by rate or by position, and gives no
// force.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Deflection of the cap, from -1 to 1 in each of its own axes: x right, y towards the user, z down.
struct SpaceMouseState {
  dvec3 push{0}, twist{0};
  std::uint32_t buttons = 0;
};
/// Parses one report. Returns false and does not change `state` if the type of the report is unknown.
bool parse_spacemouse(std::span<const std::uint8_t> report, SpaceMouseState& state);
bool is_spacemouse(std::uint16_t vendor, std::uint16_t product);

struct SpaceMouseControl {
  bool rate_control = true;  // true: the deflection sets the tool's velocity; false: it sets the tool's position
  double speed = 0.05;       // m/s, speed at full deflection with rate control
  double turn_speed = 1.0;   // rad/s, angular speed at full deflection with rate control
  double reach = 0.03;       // m, displacement at full deflection with position control
  double turn_reach = 0.6;   // rad, rotation at full deflection with position control
  double dead_zone = 0.03;
  double smoothing = 0.02;  // s, time constant of the filter; reports come at about 100 Hz, but the servo runs at 1 kHz
};
/// Makes the hand of a SpaceMouse. Its base frame H has x to the right, y away from the user, and z up. Button 1 is the
/// pedal.
std::unique_ptr<HapticDevice> make_spacemouse(std::unique_ptr<Link> link, const SpaceMouseControl& control, double rate,
                                              DeviceInfo identity);

}  // namespace typodont::haptics
