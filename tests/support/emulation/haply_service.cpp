#include "tests/support/emulation/haply_service.h"

#include <fmt/format.h>

#include <boost/beast/_experimental/test/stream.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <nlohmann/json.hpp>

namespace typodont::test {

namespace beast = boost::beast;

struct HaplyService::Connection {
  boost::asio::io_context io;
  beast::test::stream client{io};
  beast::websocket::stream<beast::test::stream, /*deflateSupported=*/false> server{io};
  beast::flat_buffer received;
};

HaplyService::HaplyService() : connection_(std::make_unique<Connection>()) {
  connection_->client.connect(connection_->server.next_layer());
  connection_->server.control_callback([this](beast::websocket::frame_type type, beast::string_view) {
    if (type == beast::websocket::frame_type::pong) ++pongs;
  });
  connection_->server.async_accept([this](beast::error_code refused) {
    if (refused) return;
    open = true;
    send_state();
    receive();
  });
}

HaplyService::~HaplyService() = default;

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
  connection_->client.write_some(boost::asio::buffer(bytes));
  connection_->io.restart();
  connection_->io.poll();
  const std::string out(connection_->client.str());
  connection_->client.clear();
  return out;
}

void HaplyService::receive() {
  connection_->server.async_read(connection_->received, [this](beast::error_code lost, std::size_t) {
    if (lost) return;
    const auto json = nlohmann::json::parse(beast::buffers_to_string(connection_->received.data()));
    connection_->received.clear();
    const auto& values = json.at("inverse3").at(0).at("commands").at("set_cursor_force").at("values");
    force = {values.at("x").get<double>(), values.at("y").get<double>(), values.at("z").get<double>()};
    ++forces;
    send_state();
    receive();
  });
}

void HaplyService::send_state() {
  const std::string text = state_text();
  const std::size_t piece = text.size() / static_cast<std::size_t>(fragments);
  for (int i = 0; i < fragments; ++i) {
    const bool last = i + 1 == fragments;
    const std::size_t at = static_cast<std::size_t>(i) * piece;
    connection_->server.write_some(last, boost::asio::buffer(text.data() + at, last ? text.size() - at : piece));
  }
}

}  // namespace typodont::test
