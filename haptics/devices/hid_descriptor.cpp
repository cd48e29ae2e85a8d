#include "haptics/devices/hid_descriptor.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "haptics/devices/hid.h"

namespace typodont::haptics {

namespace {

constexpr std::size_t kMaxFields = 512;
constexpr std::uint32_t kMaxBits = 8 * 4096;

struct Globals {
  std::uint32_t page = 0, size = 0, count = 0;
  std::int32_t minimum = 0;
  std::uint32_t maximum_raw = 0;
  std::size_t maximum_bytes = 0;
  std::uint8_t report_id = 0;
};

std::int32_t sign_extend(std::uint32_t value, std::size_t bytes) {
  if (bytes == 0 || bytes >= 4) return static_cast<std::int32_t>(value);
  const std::uint32_t sign = 1u << (8 * bytes - 1);
  return static_cast<std::int32_t>((value ^ sign) - sign);
}

}  // namespace

// Follows "Device Class Definition for HID 1.11", section 6.2.2.
std::vector<HidField> parse_descriptor(std::span<const std::uint8_t> descriptor) {
  std::vector<HidField> fields;
  Globals now;
  std::vector<Globals> stack;
  std::vector<std::uint32_t> usages;
  std::uint32_t usage_minimum = 0, usage_maximum = 0;
  bool has_range = false;
  std::vector<std::uint32_t> next_bit(256, 0);  // for each report id: bit at which the next field begins

  for (std::size_t at = 0; at < descriptor.size();) {
    const std::uint8_t head = descriptor[at];
    if (head == 0xfe) {  // skips a long item
      if (at + 1 >= descriptor.size()) break;
      at += 3u + descriptor[at + 1];
      continue;
    }
    const std::size_t bytes = (head & 3) == 3 ? 4 : head & 3;
    if (at + 1 + bytes > descriptor.size()) break;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= static_cast<std::uint32_t>(descriptor[at + 1 + i]) << (8 * i);
    at += 1 + bytes;

    const auto with_page = [&](std::uint32_t usage) { return bytes == 4 ? usage : now.page << 16 | usage; };
    switch (head & 0xfc) {
      case 0x04:
        now.page = value & 0xffff;
        break;
      case 0x14:
        now.minimum = sign_extend(value, bytes);
        break;
      case 0x24:
        now.maximum_raw = value, now.maximum_bytes = bytes;
        break;
      case 0x74:
        now.size = value;
        break;
      case 0x84:
        now.report_id = static_cast<std::uint8_t>(value);
        break;
      case 0x94:
        now.count = value;
        break;
      case 0xa4:
        if (stack.size() < 16) stack.push_back(now);
        break;
      case 0xb4:
        if (!stack.empty()) now = stack.back(), stack.pop_back();
        break;
      case 0x08:
        if (usages.size() < kMaxFields) usages.push_back(with_page(value));
        break;
      case 0x18:
        usage_minimum = with_page(value), has_range = true;
        break;
      case 0x28:
        usage_maximum = with_page(value), has_range = true;
        break;
      case 0x80: {  // the item "Input" of a HID report descriptor
        std::uint32_t& bit = next_bit[now.report_id];
        if (now.size > 32 && !(value & 1)) return fields;
        if (std::uint64_t{now.size} * now.count + bit > kMaxBits) return fields;
        const bool variable = !(value & 1) && (value & 2);  // true if the field is neither padding nor an array
        for (std::uint32_t i = 0; variable && i < now.count && fields.size() < kMaxFields; ++i) {
          std::uint32_t usage = 0;
          if (has_range && usage_maximum >= usage_minimum) {
            usage = std::min(usage_minimum + i, usage_maximum);
          } else if (!usages.empty()) {
            usage = usages[std::min<std::size_t>(i, usages.size() - 1)];
          }
          // With a minimum ≥ 0, the maximum is unsigned (0xff is 255).
          const std::int32_t maximum = now.minimum >= 0 ? static_cast<std::int32_t>(now.maximum_raw & 0x7fffffff)
                                                        : sign_extend(now.maximum_raw, now.maximum_bytes);
          fields.push_back({usage, now.report_id, bit + i * now.size, now.size, now.minimum, maximum});
        }
        bit += now.size * now.count;
        [[fallthrough]];
      }
      case 0x90:
      case 0xb0:
      case 0xa0:
      case 0xc0:  // Output, Feature, Collection and End reset local items
        usages.clear();
        has_range = false;
        usage_minimum = usage_maximum = 0;
        break;
      default:
        break;
    }
  }
  return fields;
}

std::optional<std::int32_t> field_value(const HidField& field, std::span<const std::uint8_t> report) {
  if (field.bits == 0 || field.bits > 32) return std::nullopt;
  if (field.report_id) {
    if (report.empty() || report[0] != field.report_id) return std::nullopt;
    report = report.subspan(1);
  }
  if ((std::size_t{field.bit} + field.bits + 7) / 8 > report.size()) return std::nullopt;
  std::uint64_t value = 0;
  for (std::uint32_t i = 0; i < field.bits; ++i) {
    const std::uint32_t bit = field.bit + i;
    value |= std::uint64_t{report[bit / 8] >> (bit % 8) & 1u} << i;
  }
  if (field.minimum < 0 && field.bits < 32 && value >> (field.bits - 1)) value |= ~0ull << field.bits;
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(value));
}

std::vector<std::uint8_t> report_descriptor(const std::string& path, const std::string& sysfs) {
  const std::filesystem::path node(path);
  std::ifstream in(std::filesystem::path(sysfs) / "class/hidraw" / node.filename() / "device/report_descriptor",
                   std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace typodont::haptics
