// Functions for both ends of a WebSocket (RFC 6455). The client is in haptics/devices, the server in engine/app/stream.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace typodont {

/// The server's answer to a client's key (RFC 6455, 4.2.2).
std::string websocket_accept(std::string_view key);

/// Encodes a text as one unmasked frame from server to client (RFC 6455, 5.2).
std::string websocket_text_frame(std::string_view text);

}  // namespace typodont
