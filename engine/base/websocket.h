// WebSocket functions (RFC 6455) for client (haptics/devices) and server (engine/app/live).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace typodont {

/// The server's answer to the client's key (RFC 6455, 4.2.2).
std::string websocket_accept(std::string_view key);

/// A text message as one unmasked frame (RFC 6455, 5.2).
std::string websocket_text_frame(std::string_view text);

}  // namespace typodont
