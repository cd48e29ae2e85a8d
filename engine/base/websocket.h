// Functions that client and server of a WebSocket (RFC 6455) need. The client is in haptics/devices, the server in
// engine/app/stream.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace typodont {

/// Returns the server's answer to the client's key in the handshake (RFC 6455, 4.2.2).
std::string websocket_accept(std::string_view key);

/// Encodes a text as one unmasked frame that the server sends to the client (RFC 6455, 5.2).
std::string websocket_text_frame(std::string_view text);

}  // namespace typodont
