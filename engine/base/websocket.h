// For client (haptics/devices) and server (engine/app/live), RFC 6455.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace typodont {

/// To the client's key (RFC 6455, 4.2.2).
std::string websocket_accept(std::string_view key);

/// One unmasked frame (RFC 6455, 5.2).
std::string websocket_text_frame(std::string_view text);

}  // namespace typodont
