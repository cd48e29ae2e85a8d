// A small WebSocket client (RFC 6455) for local services: text messages, no extensions, fixed buffers.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/devices/link.h"

namespace typodont::haptics {

class WebSocket {
 public:
  static constexpr std::size_t kLongestMessage = 1 << 16;

  /// Does the handshake; throws Error naming `host`.
  WebSocket(std::unique_ptr<Link> link, const std::string& host, const std::string& path);

  enum class Got { kMessage, kNothing, kLost };
  /// Gets the next complete text message, which is valid until the next call. Returns kNothing if no message came
  /// within `timeout` (0: only data that has already arrived is used). Answers the newest ping once (RFC 6455,
  /// 5.5.3). A close, an overlong message or an invalid frame counts as a lost connection. Servo thread; never
  /// allocates.
  Got receive(std::string_view& message, Nanos timeout) noexcept;
  static constexpr std::size_t kLongestSent = 1000;
  /// Sends one frame in one call. Any thread or signal handler; at most kLongestSent bytes. If a frame cannot be sent
  /// completely, the connection counts as lost.
  bool send(std::string_view text) noexcept { return send_frame(0x1, text); }
  Nanos now() noexcept { return link_->now(); }
  /// The text as a complete frame, for a watchdog process (watchdog_process.h).
  std::vector<std::uint8_t> frame_of(std::string_view text);
  int descriptor() const noexcept { return link_->descriptor(); }

 private:
  struct Frame {
    std::array<std::uint8_t, kLongestSent + 8> bytes;
    std::size_t size = 0;
  };
  Frame frame(std::uint8_t opcode, std::string_view payload) noexcept;
  bool send_frame(std::uint8_t opcode, std::string_view payload) noexcept;
  enum class Parsed { kMessage, kMore, kBroken };
  Parsed parse(std::string_view& message) noexcept;
  void answer_ping() noexcept;

  std::unique_ptr<Link> link_;
  std::vector<std::uint8_t> in_;  // received bytes that are not yet parsed: [begin_, end_)
  std::size_t begin_ = 0, end_ = 0;
  std::vector<char> message_;  // joined fragments of a message
  std::size_t length_ = 0;
  bool in_message_ = false;
  static constexpr std::size_t kLongestPing = 125;
  std::array<char, kLongestPing> ping_{};  // content of the newest ping without an answer
  std::size_t ping_size_ = 0;
  bool pinged_ = false;  // true: ping_ contains a ping without an answer
  std::atomic<bool> broken_{false};
};

}  // namespace typodont::haptics
