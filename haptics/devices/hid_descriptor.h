// HID report descriptors: bits of axes and buttons, enough for a pedal.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace typodont::haptics {

struct HidField {
  std::uint32_t usage = 0;     // page in the upper 16 bits, usage in the lower
  std::uint8_t report_id = 0;  // 0 if the device's reports have no id
  std::uint32_t bit = 0;       // after the report id
  std::uint32_t bits = 0;
  std::int32_t minimum = 0, maximum = 0;  // smallest and largest value of the field
};

/// In order; any bytes: stops at the first invalid item.
std::vector<HidField> parse_descriptor(std::span<const std::uint8_t> descriptor);

/// Empty: not in this report, which begins with its id if ids are used.
std::optional<std::int32_t> field_value(const HidField& field, std::span<const std::uint8_t> report);

}  // namespace typodont::haptics
