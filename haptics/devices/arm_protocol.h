// The four ways WoodenHaptics and Polhem boards speak. Pure functions over bytes; any garbage is survived.
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
  bool stylus = false;  // encoders D, E, F are meant
  bool button = false;  // the calibration button (latched by the board)
  int model = 0;        // text only: 1 Polhem, 2 vintage, 3 Woody
  int error = 0;        // text only: the board's own error
};

/// The protocol of a board whose input reports have this many bytes.
std::optional<ArmProtocol> protocol_of_report(std::size_t bytes);

/// One HID report. Several reports run together (a merged read) give the newest; any other length gives nothing.
std::optional<ArmReport> parse_hid(ArmProtocol protocol, std::span<const std::uint8_t> bytes);
/// One line "[model,e0,…,e5,err]" without its end.
std::optional<ArmReport> parse_text(std::string_view line);

/// What the host sends: a fixed buffer, so that zero can be sent from anywhere.
struct ArmCommand {
  std::array<std::uint8_t, 65> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> span() const { return {bytes.data(), size}; }
};
/// Milliamperes per motor, rounded towards zero and clamped to int16.
ArmCommand encode(ArmProtocol protocol, const dvec3& amperes);
/// v2 and raw HID: sets the board's own counters.
ArmCommand encode_home(ArmProtocol protocol, const std::array<std::int16_t, 6>& counts);

/// Cuts a serial stream into lines; keeps the newest whole one. Overlong rubbish is dropped.
class LineAssembler {
 public:
  void add(std::span<const std::uint8_t> bytes) noexcept;
  /// The newest whole line since the last call, valid until the next add().
  std::optional<std::string_view> take() noexcept;
  /// Lines that were passed over because a newer one was there.
  std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  std::array<char, 128> line_{}, newest_{};
  std::size_t length_ = 0, newest_length_ = 0;
  bool overlong_ = false, fresh_ = false;
  std::uint64_t skipped_ = 0;
};

}  // namespace typodont::haptics
