#include "haptics/message_stream.h"

#include <fmt/format.h>

#include "haptics/devices/fd_link.h"
#include "haptics/devices/websocket.h"

namespace typodont::haptics {

MessageStream::MessageStream(const std::string& host, int port)
    : socket_(std::make_unique<WebSocket>(connect_tcp(host, port), fmt::format("{}:{}", host, port), "/")) {}

MessageStream::~MessageStream() = default;

MessageStream::Got MessageStream::receive(std::string_view& message, Nanos timeout) noexcept {
  switch (socket_->receive(message, timeout)) {
    case WebSocket::Got::kMessage:
      return Got::kMessage;
    case WebSocket::Got::kNothing:
      return Got::kNothing;
    case WebSocket::Got::kLost:
      break;
  }
  return Got::kLost;
}

}  // namespace typodont::haptics
