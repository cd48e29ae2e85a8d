#include "haptics/devices/arm_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace typodont::haptics {

namespace {

// Sizes in bytes, in the order of ArmProtocol; 0: text lines of any length.
constexpr std::array<std::size_t, 4> kReportSizes{8, 14, 64, 0}, kCommandSizes{9, 15, 65, 0};

std::int16_t get16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8));
}

void put16(ArmCommand& command, std::size_t at, std::int16_t value) {
  command.bytes[at] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(value) & 0xff);
  command.bytes[at + 1] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(value) >> 8);
}

std::int16_t milliamperes(double amperes) {
  if (!std::isfinite(amperes)) return 0;
  return static_cast<std::int16_t>(std::clamp(std::trunc(amperes * 1000), -32767.0, 32767.0));
}

}  // namespace

std::optional<ArmProtocol> protocol_of_report(std::size_t bytes) {
  for (const ArmProtocol p : {ArmProtocol::kHidV1, ArmProtocol::kHidV2, ArmProtocol::kRawHid}) {
    if (bytes == kReportSizes[static_cast<std::size_t>(p)]) return p;
  }
  return std::nullopt;
}

std::optional<ArmReport> parse_hid(ArmProtocol protocol, std::span<const std::uint8_t> bytes) {
  const std::size_t size = kReportSizes[static_cast<std::size_t>(protocol)];
  if (size == 0 || bytes.empty() || bytes.size() % size != 0) return std::nullopt;
  const auto report = bytes.last(size);
  ArmReport out;
  const std::size_t encoders = protocol == ArmProtocol::kHidV1 ? 3 : 6;
  for (std::size_t i = 0; i < encoders; ++i) out.encoders[i] = get16(report, 2 * i);
  if (protocol != ArmProtocol::kHidV1) {
    out.stylus = true;
    out.button = get16(report, 12) & 1;
  }
  return out;
}

std::optional<ArmReport> parse_text(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  if (line.size() < 2 || line.front() != '[' || line.back() != ']') return std::nullopt;
  const char* at = line.data() + 1;
  const char* const end = line.data() + line.size() - 1;
  std::array<int, 8> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    while (at < end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, values[i]);
    if (error != std::errc()) return std::nullopt;
    at = next;
    if (i + 1 < values.size()) {
      if (at == end || *at != ',') return std::nullopt;
      ++at;
    }
  }
  if (at != end) return std::nullopt;
  ArmReport out;
  out.model = values[0];
  if (out.model < 1 || out.model > 3) return std::nullopt;
  std::copy(values.begin() + 1, values.begin() + 7, out.encoders.begin());
  out.error = values[7];
  out.stylus = true;
  return out;
}

ArmCommand encode(ArmProtocol protocol, const dvec3& amperes) {
  ArmCommand command;
  if (protocol == ArmProtocol::kText) {
    const auto result =
        fmt::format_to_n(reinterpret_cast<char*>(command.bytes.data()), command.bytes.size(), "[{},{},{}]\n",
                         milliamperes(amperes.x), milliamperes(amperes.y), milliamperes(amperes.z));
    command.size = result.size;  // the text is never longer than 24 characters
    return command;
  }
  command.size = kCommandSizes[static_cast<std::size_t>(protocol)];  // bytes[0] is the report id and stays 0
  for (int i = 0; i < 3; ++i) put16(command, 1 + 2 * static_cast<std::size_t>(i), milliamperes(amperes[i]));
  return command;
}

void LineAssembler::add(std::span<const std::uint8_t> bytes) noexcept {
  for (const std::uint8_t byte : bytes) {
    if (byte == '\n') {
      if (!overlong_) {
        if (fresh_) ++skipped_;
        newest_ = line_;
        newest_length_ = length_;
        fresh_ = true;
      }
      length_ = 0;
      overlong_ = false;
    } else if (length_ < line_.size()) {
      line_[length_++] = static_cast<char>(byte);
    } else {
      overlong_ = true;
    }
  }
}

std::optional<std::string_view> LineAssembler::take() noexcept {
  if (!fresh_) return std::nullopt;
  fresh_ = false;
  return std::string_view(newest_.data(), newest_length_);
}

}  // namespace typodont::haptics
