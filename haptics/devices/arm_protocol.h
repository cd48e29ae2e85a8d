// The four protocols of the arms' controller boards. Stateless; accepts any input.
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
  bool stylus = false;  // true: the stylus's counts D, E, F are valid
  bool button = false;  // button pressed since the last report was read
  int model = 0;        // model number in the text protocol: 1 Polhem, 2 vintage, 3 Woody
  int error = 0;        // error code of the board, only in the text protocol
};

/// Recognises a HID protocol by its input reports' length.
std::optional<ArmProtocol> protocol_of_report(std::size_t bytes);

/// Reads the newest of several HID reports; nullopt: wrong length.
std::optional<ArmReport> parse_hid(ArmProtocol protocol, std::span<const std::uint8_t> bytes);
/// Reads a line "[model,e0,…,e5,err]" without line end.
std::optional<ArmReport> parse_text(std::string_view line);

/// Command of fixed size, so that any thread and signal handler can send it.
struct ArmCommand {
  std::array<std::uint8_t, 65> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> span() const { return {bytes.data(), size}; }
};
/// Command that sets the motor currents, as 16-bit numbers of mA, rounded towards zero.
ArmCommand encode(ArmProtocol protocol, const dvec3& amperes);

/// Extracts the newest complete line from a stream of bytes. Drops lines that are too long.
class LineAssembler {
 public:
  void add(std::span<const std::uint8_t> bytes) noexcept;
  /// Returns the newest line; nullopt if there is none. Valid until add().
  std::optional<std::string_view> take() noexcept;
  /// Number of lines that were replaced by a newer one before they were read.
  std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  std::array<char, 128> line_{}, newest_{};
  std::size_t length_ = 0, newest_length_ = 0;
  bool overlong_ = false, fresh_ = false;
  std::uint64_t skipped_ = 0;
};

}  // namespace typodont::haptics
