#include "engine/base/websocket.h"

#include <openssl/sha.h>

#include <array>

#include "engine/base/base64.h"

namespace typodont {

std::string websocket_accept(std::string_view key) {
  const std::string text = std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<std::uint8_t, SHA_DIGEST_LENGTH> hash{};  // recognises a WebSocket server; not a protection
  SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data());
  return base64(hash);
}

std::string websocket_text_frame(std::string_view text) {
  constexpr std::size_t kShort = 126, kMiddle = 1 << 16;
  std::string frame(1, '\x81');  // header of a text message in a single frame
  const int bytes = text.size() < kShort ? 0 : text.size() < kMiddle ? 2 : 8;
  frame += static_cast<char>(bytes == 0 ? text.size() : bytes == 2 ? 126 : 127);
  for (int i = bytes - 1; i >= 0; --i) frame += static_cast<char>(std::uint64_t{text.size()} >> (8 * i) & 0xff);
  return frame.append(text);
}

}  // namespace typodont
