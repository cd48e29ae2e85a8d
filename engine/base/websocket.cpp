#include "engine/base/websocket.h"

#include <array>
#include <bit>

#include "engine/base/base64.h"

namespace typodont {

namespace {

// SHA-1 (FIPS 180-4, 6.1). The handshake uses it to recognise a WebSocket server, not as protection.
std::array<std::uint8_t, 20> sha1(std::string_view text) {
  std::string m(text);
  m += '\x80';
  while (m.size() % 64 != 56) m += '\0';
  const std::uint64_t length = std::uint64_t{text.size()} * 8;
  for (int i = 7; i >= 0; --i) m += static_cast<char>(length >> (8 * i) & 0xff);
  std::array<std::uint32_t, 5> h{0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
  for (std::size_t block = 0; block < m.size(); block += 64) {
    std::array<std::uint32_t, 80> w{};
    for (std::size_t i = 0; i < 16; ++i) {
      for (std::size_t k = 0; k < 4; ++k) w[i] = w[i] << 8 | static_cast<std::uint8_t>(m[block + 4 * i + k]);
    }
    for (std::size_t i = 16; i < 80; ++i) w[i] = std::rotl(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
    auto [a, b, c, d, e] = h;
    for (std::size_t i = 0; i < 80; ++i) {
      std::uint32_t f, k;
      if (i < 20)
        f = (b & c) | (~b & d), k = 0x5A827999;
      else if (i < 40)
        f = b ^ c ^ d, k = 0x6ED9EBA1;
      else if (i < 60)
        f = (b & c) | (b & d) | (c & d), k = 0x8F1BBCDC;
      else
        f = b ^ c ^ d, k = 0xCA62C1D6;
      const std::uint32_t next = std::rotl(a, 5) + f + e + k + w[i];
      e = d, d = c, c = std::rotl(b, 30), b = a, a = next;
    }
    h[0] += a, h[1] += b, h[2] += c, h[3] += d, h[4] += e;
  }
  std::array<std::uint8_t, 20> out{};
  for (std::size_t i = 0; i < 20; ++i) out[i] = static_cast<std::uint8_t>(h[i / 4] >> (24 - 8 * (i % 4)));
  return out;
}

}  // namespace

std::string websocket_accept(std::string_view key) {
  return base64(sha1(std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"));
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
