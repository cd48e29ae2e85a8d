// Parses HID report descriptors as far as a pedal needs them: the bits of axes and buttons in each report.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace typodont::haptics {

struct HidField {
  std::uint32_t usage = 0;     // usage page << 16 | usage
  std::uint8_t report_id = 0;  // 0: reports carry no id
  std::uint32_t bit = 0;       // bit offset in the report, after its id
  std::uint32_t bits = 0;
  std::int32_t minimum = 0, maximum = 0;  // logical range of the value
};

/// All variable input fields, in order. Invalid input is safe: parsing stops at the first invalid item.
std::vector<HidField> parse_descriptor(std::span<const std::uint8_t> descriptor);

/// The field's value in a report; if reports have ids, the report begins with its id byte. Returns nothing if the
/// report does not contain the field.
std::optional<std::int32_t> field_value(const HidField& field, std::span<const std::uint8_t> report);

}  // namespace typodont::haptics
