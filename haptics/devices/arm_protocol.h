// The four protocols of WoodenHaptics and Polhem boards. Pure functions over bytes; invalid input is safe.
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
  bool stylus = false;  // true: encoders D, E, F are valid
  bool button = false;  // the calibration button; the board latches it
  int model = 0;        // text protocol only: 1 Polhem, 2 vintage, 3 Woody
  int error = 0;        // text protocol only: error code of the board
};

/// Returns the protocol of a board whose input reports have this length.
std::optional<ArmProtocol> protocol_of_report(std::size_t bytes);

/// Parses one HID report. If several reports were read together, the newest is used. For any other length, returns
/// nothing.
std::optional<ArmReport> parse_hid(ArmProtocol protocol, std::span<const std::uint8_t> bytes);
/// Parses one line "[model,e0,…,e5,err]" without its line end.
std::optional<ArmReport> parse_text(std::string_view line);

/// A command to the board in a fixed buffer, so that zero force can be sent from any thread or signal handler.
struct ArmCommand {
  std::array<std::uint8_t, 65> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> span() const { return {bytes.data(), size}; }
};
/// Milliamperes per motor, rounded towards zero and limited to int16.
ArmCommand encode(ArmProtocol protocol, const dvec3& amperes);
/// The command that sets the board's counters, for the protocols v2 and raw HID.
ArmCommand encode_home(ArmProtocol protocol, const std::array<std::int16_t, 6>& counts);

/// Splits a serial stream into lines and keeps the newest complete one. Overlong input is discarded.
class LineAssembler {
 public:
  void add(std::span<const std::uint8_t> bytes) noexcept;
  /// Returns the newest complete line since the last call. It is valid until the next add().
  std::optional<std::string_view> take() noexcept;
  /// Number of lines that were skipped because a newer line existed.
  std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  std::array<char, 128> line_{}, newest_{};
  std::size_t length_ = 0, newest_length_ = 0;
  bool overlong_ = false, fresh_ = false;
  std::uint64_t skipped_ = 0;
};

}  // namespace typodont::haptics
