// Parses HID report descriptors as far as a pedal needs them: the bits of axes and buttons in each report.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace typodont::haptics {

struct HidField {
  std::uint32_t usage = 0;     // page << 16 | usage
  std::uint8_t report_id = 0;  // 0: reports carry no id
  std::uint32_t bit = 0;       // offset in the report, after its id
  std::uint32_t bits = 0;
  std::int32_t minimum = 0, maximum = 0;  // logical range
};

/// All variable input fields, in order. Invalid input is safe; parsing stops there.
std::vector<HidField> parse_descriptor(std::span<const std::uint8_t> descriptor);

/// The field's value in a report (with its id byte in front if it has one); nothing if the report does not contain it.
std::optional<std::int32_t> field_value(const HidField& field, std::span<const std::uint8_t> report);

}  // namespace typodont::haptics
