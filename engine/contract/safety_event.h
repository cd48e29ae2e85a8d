// What the layer that keeps motors from hurting a hand did or saw (haptics/devices/safe_device.h). Bits: more than one
// may be set. Safety layer → recorder, render.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

namespace typodont {

enum class SafetyEvent : std::uint32_t {
  kNone = 0,
  kNotFinite = 1u << 0,    // a force or a pose was not finite: zero
  kForceLimit = 1u << 1,   // clipped to the peak
  kSlewLimit = 1u << 2,    // rose too fast: slowed
  kThermal = 1u << 3,      // clipped to what the motors bear
  kWatchdog = 1u << 4,     // the servo was silent: zero
  kDeviceFault = 1u << 5,  // the device reported a fault: zero
  kDeviceLost = 1u << 6,   // the device is gone: zero
  kJump = 1u << 7,         // the hand moved faster than hands move: zero
  kClock = 1u << 8,        // time stood still, ran backwards or leapt: zero
  kEmergency = 1u << 9,    // the emergency key: ramped to zero
  kPedalStuck = 1u << 10,  // held too long: the drill stops
};
constexpr std::uint32_t bits(SafetyEvent event) {
  return static_cast<std::uint32_t>(event);
}

/// Names for files and catalogues, in the order of the bits.
inline constexpr std::array<std::pair<SafetyEvent, std::string_view>, 11> kSafetyEventNames{{
    {SafetyEvent::kNotFinite, "not_finite"},
    {SafetyEvent::kForceLimit, "force_limit"},
    {SafetyEvent::kSlewLimit, "slew_limit"},
    {SafetyEvent::kThermal, "thermal"},
    {SafetyEvent::kWatchdog, "watchdog"},
    {SafetyEvent::kDeviceFault, "device_fault"},
    {SafetyEvent::kDeviceLost, "device_lost"},
    {SafetyEvent::kJump, "jump"},
    {SafetyEvent::kClock, "clock"},
    {SafetyEvent::kEmergency, "emergency"},
    {SafetyEvent::kPedalStuck, "pedal_stuck"},
}};

}  // namespace typodont
