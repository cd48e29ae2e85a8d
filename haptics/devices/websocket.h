// A small WebSocket client (RFC 6455) for services on this computer: text messages, no extensions, buffers of fixed
// size. Boost.Beast does not suffice here: after a read that times out, its stream is unusable, its synchronous reads
// may wait for any number of frames, and a signal handler must not write to it.
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

  /// Performs the handshake. Throws an Error that names `host`.
  WebSocket(std::unique_ptr<Link> link, const std::string& host, const std::string& path);

  enum class Got { kMessage, kNothing, kLost };
  /// Waits up to `timeout` (ns) for the next text message, valid until the next call. Answers the newest ping once (RFC
  /// 6455, 5.5.3). A closing, invalid or too long frame counts as a lost connection. Servo thread only.
  Got receive(std::string_view& message, Nanos timeout) noexcept;
  static constexpr std::size_t kLongestSent = 1000;
  /// Sends a text of at most kLongestSent bytes as one frame with one system call. If it cannot be sent completely, the
  /// connection counts as lost. Any thread or signal handler.
  bool send(std::string_view text) noexcept { return send_frame(0x1, text); }
  Nanos now() noexcept { return link_->now(); }
  /// Returns the text as a complete frame, for a watchdog process (watchdog_process.h).
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
  std::vector<std::uint8_t> in_;  // received bytes; the bytes in [begin_, end_) are not yet parsed
  std::size_t begin_ = 0, end_ = 0;
  std::vector<char> message_;  // the joined fragments of a message
  std::size_t length_ = 0;
  bool in_message_ = false;
  static constexpr std::size_t kLongestPing = 125;
  std::array<char, kLongestPing> ping_{};  // content of the newest ping that was not yet answered
  std::size_t ping_size_ = 0;
  bool pinged_ = false;  // true: ping_ contains a ping without answer
  std::atomic<bool> broken_{false};
};

}  // namespace typodont::haptics
