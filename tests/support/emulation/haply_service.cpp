#include "tests/support/emulation/haply_service.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "engine/base/websocket.h"
#include "haptics/devices/websocket.h"

namespace typodont::test {

std::string HaplyService::frame(const std::string& text, int fragments, std::uint8_t opcode) {
  std::string out;
  const std::size_t piece =
      (text.size() + static_cast<std::size_t>(fragments) - 1) / static_cast<std::size_t>(fragments);
  for (int i = 0; i < fragments; ++i) {
    const std::string part = text.substr(std::min(text.size(), static_cast<std::size_t>(i) * piece), piece);
    out += static_cast<char>((i + 1 == fragments ? 0x80 : 0) | (i == 0 ? opcode : 0));
    if (part.size() < 126) {
      out += static_cast<char>(part.size());
    } else {
      out += static_cast<char>(126);
      out += static_cast<char>(part.size() >> 8);
      out += static_cast<char>(part.size() & 0xff);
    }
    out += part;
  }
  return out;
}

std::string HaplyService::state_text() const {
  return fmt::format(
      R"({{"inverse3":[{{"device_id":"0A1B","state":{{"cursor_position":{{"x":{},"y":{},"z":{}}},"cursor_velocity":{{"x":0,"y":0,"z":0}}}}}}],)"
      R"("wireless_verse_grip":[{{"device_id":"77","state":{{"orientation":{{"w":0.8,"x":0.6,"y":0,"z":0}},"buttons":{{"a":{}}}}}}}]}})",
      position.x, position.y, position.z, button);
}

std::string HaplyService::feed(const std::string& bytes) {
  in_ += bytes;
  std::string out;
  if (!open) {
    const std::size_t end = in_.find("\r\n\r\n");
    if (end == std::string::npos) return out;
    const std::size_t key = in_.find("Sec-WebSocket-Key: ") + 19;
    out = "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: " +
          websocket_accept(in_.substr(key, in_.find("\r\n", key) - key)) + "\r\n\r\n" + frame(state_text());
    in_.erase(0, end + 4);
    open = true;
  }
  for (;;) {
    if (in_.size() < 2) return out;
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(in_[i]); };
    std::size_t size = byte(1) & 0x7f, head = 2;
    if (size == 126) {
      if (in_.size() < 4) return out;
      size = static_cast<std::size_t>(byte(2)) << 8 | byte(3);
      head = 4;
    }
    if (in_.size() < head + 4 + size) return out;
    std::string text;
    for (std::size_t i = 0; i < size; ++i) text += static_cast<char>(byte(head + 4 + i) ^ byte(head + i % 4));
    const int opcode = byte(0) & 15;
    in_.erase(0, head + 4 + size);
    if (opcode == 0xA) {
      ++pongs;
      continue;
    }
    const auto json = nlohmann::json::parse(text);
    const auto& values = json.at("inverse3").at(0).at("commands").at("set_cursor_force").at("values");
    force = {values.at("x").get<double>(), values.at("y").get<double>(), values.at("z").get<double>()};
    ++forces;
    out += frame(state_text(), fragments);
  }
}

}  // namespace typodont::test
