// Events of the safety layer between motors and hand (haptics/devices/safe_device.h). They are bits, because several
// may occur at once. Safety layer → recorder, renderer.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

namespace typodont {

enum class SafetyEvent : std::uint32_t {
  kNone = 0,
  kNotFinite = 1u << 0,    // force or pose is not finite: zero force
  kForceLimit = 1u << 1,   // the force was clipped to the peak force
  kSlewLimit = 1u << 2,    // the force rose too fast: its rate was limited
  kThermal = 1u << 3,      // the force was clipped, to limit the motors' heat
  kWatchdog = 1u << 4,     // no new force came in time: zero force
  kDeviceFault = 1u << 5,  // the device reported a fault: zero force
  kDeviceLost = 1u << 6,   // the connection was lost: zero force
  kJump = 1u << 7,         // the hand's position jumped faster than a hand moves: zero force
  kClock = 1u << 8,        // the clock stopped, ran backwards or jumped: zero force
  kEmergency = 1u << 9,    // the emergency key is on: the force ramps to zero
  kPedalStuck = 1u << 10,  // the pedal was pressed for too long: the drill stops
};
constexpr std::uint32_t bits(SafetyEvent event) {
  return static_cast<std::uint32_t>(event);
}

/// Names in files and text catalogues, ordered as the bits.
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
