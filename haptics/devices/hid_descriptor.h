// Parser of HID report descriptors: finds the bits of axes and buttons, as far as a pedal needs it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace typodont::haptics {

struct HidField {
  std::uint32_t usage = 0;     // usage page in the upper 16 bits, usage in the lower 16
  std::uint8_t report_id = 0;  // id of the report with this field; 0: reports have no id
  std::uint32_t bit = 0;       // position of the field, counted after the report id
  std::uint32_t bits = 0;
  std::int32_t minimum = 0, maximum = 0;  // smallest and largest value of the field
};

/// Returns the fields in the order of the descriptor. Accepts any bytes; stops at the first invalid item.
std::vector<HidField> parse_descriptor(std::span<const std::uint8_t> descriptor);

/// Returns a field's value; nullopt if this report does not contain it. If the device uses report ids, `report` begins
/// with its id.
std::optional<std::int32_t> field_value(const HidField& field, std::span<const std::uint8_t> report);

}  // namespace typodont::haptics
