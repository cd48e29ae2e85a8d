// Parses HID report descriptors. It finds the bits of axes and buttons in each report, which is enough for a pedal.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace typodont::haptics {

struct HidField {
  std::uint32_t usage = 0;  // meaning of the field: the usage page in the upper 16 bits, the usage in the lower 16 bits
  std::uint8_t report_id = 0;  // 0 if the device's reports have no id
  std::uint32_t bit = 0;       // position of the first bit in the report, counted after the report id
  std::uint32_t bits = 0;
  std::int32_t minimum = 0, maximum = 0;  // smallest and largest value of the field
};

/// Returns all variable input fields in order. The descriptor may contain any bytes: parsing stops at the first invalid
/// item.
std::vector<HidField> parse_descriptor(std::span<const std::uint8_t> descriptor);

/// Returns the value of a field in a report, or no value if the report does not contain the field. If the device uses
/// report ids, the report begins with its id byte.
std::optional<std::int32_t> field_value(const HidField& field, std::span<const std::uint8_t> report);

}  // namespace typodont::haptics
