#include "haptics/devices/safety.h"

#include <array>
#include <utility>

namespace typodont::haptics {

std::string describe_safety(std::uint32_t events) {
  static constexpr std::array<std::pair<SafetyEvent, const char*>, 11> kWords{{
      {SafetyEvent::kNotFinite, "not finite"},
      {SafetyEvent::kForceLimit, "force limit"},
      {SafetyEvent::kSlewLimit, "slew limit"},
      {SafetyEvent::kThermal, "motors warm"},
      {SafetyEvent::kWatchdog, "watchdog"},
      {SafetyEvent::kDeviceFault, "device fault"},
      {SafetyEvent::kDeviceLost, "device lost"},
      {SafetyEvent::kJump, "jump"},
      {SafetyEvent::kClock, "clock"},
      {SafetyEvent::kEmergency, "emergency stop"},
      {SafetyEvent::kPedalStuck, "pedal stuck"},
  }};
  std::string text;
  for (const auto& [event, word] : kWords) {
    if (!(events & bits(event))) continue;
    if (!text.empty()) text += ", ";
    text += word;
  }
  return text;
}

}  // namespace typodont::haptics
