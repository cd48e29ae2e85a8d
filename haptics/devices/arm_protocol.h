// The four protocols of the boards of WoodenHaptics and Polhem arms. The functions convert between bytes and values,
// have no state, and accept any input.
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
  bool stylus = false;  // true if the counts of the encoders D, E, F are valid
  bool button = false;  // true if the calibration button was pressed; the board stores this until it is read
  int model = 0;        // number of the model, only in the text protocol: 1 Polhem, 2 vintage, 3 Woody
  int error = 0;        // error code of the board, only in the text protocol
};

/// Returns the protocol of a board whose input reports have this length.
std::optional<ArmProtocol> protocol_of_report(std::size_t bytes);

/// Parses the bytes of a HID report. If several reports were read together, the newest one is used. Returns no value if
/// the length is wrong.
std::optional<ArmReport> parse_hid(ArmProtocol protocol, std::span<const std::uint8_t> bytes);
/// Parses one line "[model,e0,…,e5,err]". The caller must have removed the line end.
std::optional<ArmReport> parse_text(std::string_view line);

/// A command to the board. Its buffer has a fixed size, so that any thread or signal handler can send zero force.
struct ArmCommand {
  std::array<std::uint8_t, 65> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> span() const { return {bytes.data(), size}; }
};
/// Encodes the currents of the motors in mA, rounded towards zero and limited to 16 bits.
ArmCommand encode(ArmProtocol protocol, const dvec3& amperes);
/// Encodes the command that sets the counters of the board, for the protocols v2 and raw HID.
ArmCommand encode_home(ArmProtocol protocol, const std::array<std::int16_t, 6>& counts);

/// Divides a serial stream into lines and stores the newest complete line. Lines that are too long are discarded.
class LineAssembler {
 public:
  void add(std::span<const std::uint8_t> bytes) noexcept;
  /// Returns the newest complete line since the last call, or no value. The line is valid until the next add().
  std::optional<std::string_view> take() noexcept;
  /// Returns the number of lines that were skipped because a newer line had arrived.
  std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  std::array<char, 128> line_{}, newest_{};
  std::size_t length_ = 0, newest_length_ = 0;
  bool overlong_ = false, fresh_ = false;
  std::uint64_t skipped_ = 0;
};

}  // namespace typodont::haptics
