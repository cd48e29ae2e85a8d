// Four protocols of the boards. Stateless, any input.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/base/pose.h"

namespace typodont::haptics {

enum class ArmProtocol { kHidV1, kHidV2, kRawHid, kText };

struct ArmReport {
  std::array<std::int32_t, 6> encoders{};
  bool stylus = false;  // D, E, F are valid
  bool button = false;  // pressed; kept until read
  int model = 0;        // text protocol: 1 Polhem, 2 vintage, 3 Woody
  int error = 0;        // error code of the board, only in the text protocol
};

/// By the length of input reports.
std::optional<ArmProtocol> protocol_of_report(std::size_t bytes);

/// Newest of several reports; empty: wrong length.
std::optional<ArmReport> parse_hid(ArmProtocol protocol, std::span<const std::uint8_t> bytes);
/// "[model,e0,…,e5,err]" without line end.
std::optional<ArmReport> parse_text(std::string_view line);

/// Fixed size: for any thread and signal handler.
struct ArmCommand {
  std::array<std::uint8_t, 65> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> span() const { return {bytes.data(), size}; }
};
/// mA, rounded to zero, 16 bits.
ArmCommand encode(ArmProtocol protocol, const dvec3& amperes);
/// Sets the counters; v2 and raw HID.
ArmCommand encode_home(ArmProtocol protocol, const std::array<std::int16_t, 6>& counts);

/// Newest complete line of a stream; too long ones are dropped.
class LineAssembler {
 public:
  void add(std::span<const std::uint8_t> bytes) noexcept;
  /// Empty: none. Valid until add().
  std::optional<std::string_view> take() noexcept;
  /// Lines overtaken by newer ones.
  std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  std::array<char, 128> line_{}, newest_{};
  std::size_t length_ = 0, newest_length_ = 0;
  bool overlong_ = false, fresh_ = false;
  std::uint64_t skipped_ = 0;
};

}  // namespace typodont::haptics
