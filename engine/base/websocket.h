// What both ends of a WebSocket (RFC 6455) need: the client is in haptics/devices, the server in engine/app/stream.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace typodont {

std::string base64(std::span<const std::uint8_t> bytes);

/// The answer a server owes to a key (4.2.2).
std::string websocket_accept(std::string_view key);

/// A text as one frame from server to client (5.2): not masked.
std::string websocket_text_frame(std::string_view text);

}  // namespace typodont
