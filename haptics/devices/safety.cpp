#include <algorithm>

#include "engine/contract/safety_event.h"
#include "haptics/device_safety.h"

namespace typodont::haptics {

std::string describe_safety(std::uint32_t events) {
  std::string text;
  for (const auto& [event, name] : kSafetyEventNames) {
    if (!(events & bits(event))) continue;
    if (!text.empty()) text += ", ";
    text += name;
  }
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

}  // namespace typodont::haptics
