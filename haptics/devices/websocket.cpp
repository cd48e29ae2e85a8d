#include "haptics/devices/websocket.h"

#include <fmt/format.h>
#include <openssl/sha.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "engine/base/base64.h"
#include "engine/base/error.h"
#include "engine/base/lower_case.h"

namespace typodont::haptics {

namespace {

/// The server's answer to the client's key (RFC 6455, 4.2.2).
std::string accept_for(const std::string& key) {
  const std::string text = key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<std::uint8_t, SHA_DIGEST_LENGTH> hash{};  // recognises a WebSocket server; not a protection
  SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data());
  return base64(hash);
}

}  // namespace

WebSocket::WebSocket(std::unique_ptr<Link> link, const std::string& host, const std::string& path)
    : link_(std::move(link)), in_(2 * kLongestMessage), message_(kLongestMessage) {
  std::random_device random;
  std::array<std::uint8_t, 16> nonce;
  for (auto& byte : nonce) byte = static_cast<std::uint8_t>(random());
  const std::string key = base64(nonce);
  const std::string request = fmt::format(
      "GET {} HTTP/1.1\r\nHost: {}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Key: {}\r\nSec-WebSocket-Version: 13\r\n\r\n",
      path, host, key);
  link_->write({reinterpret_cast<const std::uint8_t*>(request.data()), request.size()});

  std::string answer;
  const Nanos give_up = link_->now() + 2 * kNanosPerSecond;
  std::size_t head_end = std::string::npos;
  while (head_end == std::string::npos) {
    std::uint8_t buffer[1024];
    const int n = link_->read(buffer, 100'000'000);
    if (n < 0 || link_->now() > give_up || answer.size() > 16'384) {
      throw Error(host, "", "no WebSocket handshake", "the device's service");
    }
    answer.append(reinterpret_cast<const char*>(buffer), static_cast<std::size_t>(n));
    head_end = answer.find("\r\n\r\n");
  }
  const std::string head = answer.substr(0, head_end + 2);
  const std::string lower = lower_case(head);
  const std::size_t at = lower.find("\r\nsec-websocket-accept:");
  std::string accept;
  if (at != std::string::npos) {
    accept = head.substr(at + 23, head.find("\r\n", at + 2) - at - 23);
    std::erase(accept, ' ');
  }
  if (!head.starts_with("HTTP/1.1 101") || accept != accept_for(key)) {
    throw Error(host, "", head.substr(0, head.find("\r\n")), "a WebSocket server that accepts our key");
  }
  end_ = answer.size() - (head_end + 4);  // the answer's packet may also contain the first frames
  std::memcpy(in_.data(), answer.data() + head_end + 4, end_);
}

WebSocket::Frame WebSocket::frame(std::uint8_t opcode, std::string_view payload) noexcept {
  Frame out;
  auto& frame = out.bytes;
  std::size_t n = 0;
  frame[n++] = static_cast<std::uint8_t>(0x80 | opcode);
  if (payload.size() < 126) {
    frame[n++] = static_cast<std::uint8_t>(0x80 | payload.size());
  } else {
    frame[n++] = 0x80 | 126;
    frame[n++] = static_cast<std::uint8_t>(payload.size() >> 8);
    frame[n++] = static_cast<std::uint8_t>(payload.size() & 0xff);
  }
  // Masks the frame, as a client must, to protect web proxies (RFC 6455, 5.3). Within one computer there is no proxy,
  // so the low bits of the time are random enough.
  const auto mask = static_cast<std::uint32_t>(link_->now());
  for (int i = 0; i < 4; ++i) frame[n++] = static_cast<std::uint8_t>(mask >> (8 * i));
  for (std::size_t i = 0; i < payload.size(); ++i) {
    frame[n++] = static_cast<std::uint8_t>(static_cast<std::uint8_t>(payload[i]) ^ (mask >> (8 * (i % 4))));
  }
  out.size = n;
  return out;
}

bool WebSocket::send_frame(std::uint8_t opcode, std::string_view payload) noexcept {
  if (payload.size() > kLongestSent || broken_.load()) return false;
  const Frame out = frame(opcode, payload);
  if (link_->write({out.bytes.data(), out.size})) return true;
  broken_.store(true);
  return false;
}

std::vector<std::uint8_t> WebSocket::frame_of(std::string_view text) {
  const Frame out = frame(0x1, text.substr(0, kLongestSent));
  return {out.bytes.begin(), out.bytes.begin() + static_cast<std::ptrdiff_t>(out.size)};
}

WebSocket::Parsed WebSocket::parse(std::string_view& message) noexcept {
  for (;;) {
    const std::uint8_t* const p = in_.data() + begin_;
    const std::size_t have = end_ - begin_;
    if (have < 2) return Parsed::kMore;
    const bool last = p[0] & 0x80;
    const std::uint8_t opcode = p[0] & 0x0f;
    // Frames with reserved bits or a mask are invalid: no extensions were requested, and servers never mask.
    if (p[0] & 0x70 || p[1] & 0x80) return Parsed::kBroken;
    std::uint64_t size = p[1] & 0x7f;
    std::size_t head = 2;
    if (size >= 126) {
      const std::size_t extra = size == 126 ? 2 : 8;
      if (have < 2 + extra) return Parsed::kMore;
      size = 0;
      for (std::size_t i = 0; i < extra; ++i) size = size << 8 | p[2 + i];
      head += extra;
    }
    if (size > kLongestMessage) return Parsed::kBroken;
    if (have < head + size) return Parsed::kMore;
    const char* const payload = reinterpret_cast<const char*>(p + head);
    begin_ += head + static_cast<std::size_t>(size);
    switch (opcode) {
      case 0x0:
      case 0x1:
      case 0x2:
        if ((opcode == 0) != in_message_) return Parsed::kBroken;
        if (opcode != 0) length_ = 0;
        if (length_ + size > kLongestMessage) return Parsed::kBroken;
        std::memcpy(message_.data() + length_, payload, static_cast<std::size_t>(size));
        length_ += static_cast<std::size_t>(size);
        in_message_ = !last;
        if (!last) break;
        message = {message_.data(), length_};
        return Parsed::kMessage;
      case 0x9:
        if (size > kLongestPing) return Parsed::kBroken;
        std::memcpy(ping_.data(), payload, static_cast<std::size_t>(size));
        ping_size_ = static_cast<std::size_t>(size);
        pinged_ = true;
        break;
      case 0xA:
        break;
      default:
        return Parsed::kBroken;  // a frame that closes the connection, or an invalid frame
    }
  }
}

void WebSocket::answer_ping() noexcept {
  if (!pinged_) return;
  pinged_ = false;
  send_frame(0xA, {ping_.data(), ping_size_});
}

WebSocket::Got WebSocket::receive(std::string_view& message, Nanos timeout) noexcept {
  const Nanos until = link_->now() + timeout;
  for (bool read = false;; read = true) {
    const Parsed parsed = parse(message);
    answer_ping();
    switch (parsed) {
      case Parsed::kMessage:
        return Got::kMessage;
      case Parsed::kBroken:
        return Got::kLost;
      case Parsed::kMore:
        break;
    }
    if (begin_ > 0) {
      std::memmove(in_.data(), in_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    // The buffer always has space: it holds two messages of maximum length, and longer frames were refused above.
    if (broken_.load()) return Got::kLost;
    const Nanos left = std::min(until - link_->now(), timeout);
    if (read && left <= 0) return Got::kNothing;
    const int n = link_->read(std::span(in_).subspan(end_), std::max<Nanos>(left, 0));
    if (n < 0) return Got::kLost;
    end_ += static_cast<std::size_t>(n);
  }
}

}  // namespace typodont::haptics
