// Receives text messages from a WebSocket server (RFC 6455), such as the state of a session on another computer.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "engine/base/clock.h"

namespace typodont::haptics {

class WebSocket;

/// Connection to a server. Used by one thread.
class MessageStream {
 public:
  /// Connects to the server. Throws Error.
  MessageStream(const std::string& host, int port);
  ~MessageStream();
  MessageStream(const MessageStream&) = delete;
  MessageStream& operator=(const MessageStream&) = delete;

  enum class Got { kMessage, kNothing, kLost };
  /// Waits up to `timeout` (ns) for a message, which is valid until the next call.
  Got receive(std::string_view& message, Nanos timeout) noexcept;

 private:
  std::unique_ptr<WebSocket> socket_;
};

}  // namespace typodont::haptics
