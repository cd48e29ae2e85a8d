// 3Dconnexion SpaceMouse: controls the tool in six degrees of freedom, by rate or by position. It gives no force.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Deflection of the cap in its own axes: x right, y toward the user, z down; each -1..1.
struct SpaceMouseState {
  dvec3 push{0}, twist{0};
  std::uint32_t buttons = 0;
};
/// Parses one report. Returns false and does not change `state` if the report has an unknown type.
bool parse_spacemouse(std::span<const std::uint8_t> report, SpaceMouseState& state);
bool is_spacemouse(std::uint16_t vendor, std::uint16_t product);

struct SpaceMouseControl {
  bool rate_control = true;  // false: the cap's deflection sets the tool's position
  double speed = 0.05;       // m/s at full deflection, rate control
  double turn_speed = 1.0;   // rad/s at full deflection, rate control
  double reach = 0.03;       // m at full deflection, position control
  double turn_reach = 0.6;   // rad at full deflection, position control
  double dead_zone = 0.03;
  double smoothing = 0.02;  // s, time constant; reports come at about 100 Hz, the servo runs at 1 kHz
};
/// Makes the hand. Frame H: x right, y away from the user, z up. Button 1 is the pedal.
std::unique_ptr<HapticDevice> make_spacemouse(std::unique_ptr<Link> link, const SpaceMouseControl& control, double rate,
                                              DeviceInfo identity);

}  // namespace typodont::haptics
