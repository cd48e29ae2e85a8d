// Tests that every parser of bytes from outside handles any bytes: random bytes, and valid bytes of which a few are
// changed.
#include <gtest/gtest.h>

#include <random>

#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/pedal.h"
#include "haptics/devices/spacemouse.h"
#include "haptics/devices/websocket.h"
#include "tests/support/emulation/haply_service.h"

namespace typodont::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;

class Garbage {
 public:
  explicit Garbage(std::uint32_t seed) : random_(seed) {}
  Bytes bytes(std::size_t most) {
    Bytes out(random_() % (most + 1));
    for (auto& b : out) b = static_cast<std::uint8_t>(random_());
    return out;
  }
  std::string mutated(std::string text) {
    for (int i = 0; i < 3 && !text.empty(); ++i) {
      const std::size_t at = random_() % text.size();
      switch (random_() % 3) {
        case 0:
          text[at] = static_cast<char>(random_());
          break;
        case 1:
          text.erase(at, 1 + random_() % 8);
          break;
        default:
          text.insert(at, 1, "[]{}\",:0-e\\"[random_() % 11]);
          break;
      }
    }
    return text;
  }

 private:
  std::mt19937 random_;
};

TEST(Parsers, ArmReportsOfRandomBytesAreReadOrRefused) {
  Garbage garbage(1);
  for (int i = 0; i < 20'000; ++i) {
    const Bytes bytes = garbage.bytes(200);
    for (const ArmProtocol p : {ArmProtocol::kHidV1, ArmProtocol::kHidV2, ArmProtocol::kRawHid}) {
      const auto report = parse_hid(p, bytes);
      if (!report) continue;
      for (const auto e : report->encoders) ASSERT_TRUE(e >= -32768 && e <= 32767);
    }
    const auto report = parse_text(garbage.mutated("[1,8312,-10366,19764,0,30,0,0]"));
    if (report) {
      ASSERT_TRUE(report->model >= 1 && report->model <= 3);
    }
  }
}

TEST(Parsers, LinesFromAnyStreamAreNeverLongerThanTheBuffer) {
  Garbage garbage(2);
  LineAssembler lines;
  for (int i = 0; i < 5000; ++i) {
    lines.add(garbage.bytes(300));
    if (const auto line = lines.take()) {
      ASSERT_LE(line->size(), 128u);
    }
  }
}

TEST(Parsers, SpaceMouseAxesStayWithinOne) {
  Garbage garbage(3);
  SpaceMouseState state;
  for (int i = 0; i < 20'000; ++i) {
    Bytes bytes = garbage.bytes(16);
    if (!bytes.empty()) bytes[0] %= 4;
    parse_spacemouse(bytes, state);
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(std::abs(state.push[k]) <= 1 && std::abs(state.twist[k]) <= 1);
  }
}

TEST(Parsers, AnyReportCanBeReadWithTheFieldsOfAnyDescriptor) {
  Garbage garbage(4);
  for (int i = 0; i < 5000; ++i) {
    Bytes descriptor = garbage.bytes(120);
    // Items with a meaning are inserted at regular positions. Without them, random bytes would hardly ever declare an
    // input.
    for (std::size_t k = 0; k + 1 < descriptor.size(); k += 6) {
      static constexpr std::uint8_t kHeads[] = {0x05, 0x09, 0x15, 0x25, 0x75, 0x95, 0x81, 0x85, 0xa4, 0xb4, 0x26, 0x96};
      descriptor[k] = kHeads[descriptor[k] % std::size(kHeads)];
    }
    const Bytes report = garbage.bytes(64);
    for (const HidField& field : parse_descriptor(descriptor)) field_value(field, report);
    if (const auto kind = pedal_kind(7, 7, descriptor)) {
      const auto value = pedal_value(*kind, report);
      if (value) {
        ASSERT_TRUE(*value >= 0 && *value <= 1);
      }
    }
  }
}

TEST(Parsers, HaplyStatesAreFiniteForAnyMessage) {
  Garbage garbage(5);
  const std::string good = test::HaplyService().state_text();
  int read = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto state = parse_haply(garbage.mutated(good));
    if (!state) continue;
    ++read;
    ASSERT_TRUE(is_finite(state->position));
    ASSERT_NEAR(glm::length(state->orientation), 1, 1e-9);
    ASSERT_EQ(state->id.back(), 0);
  }
  EXPECT_GT(read, 1000);  // many changes have no effect on validity
}

/// Answers the handshake, then sends the given bytes.
class Player : public Link {
 public:
  Bytes play;
  int read(std::span<std::uint8_t> buffer, Nanos) noexcept override {
    const std::size_t n = std::min({buffer.size(), play.size(), std::size_t{97}});
    if (n == 0) return t_ += kNanosPerSecond, play_ended_ ? -1 : 0;
    std::copy_n(play.begin(), n, buffer.begin());
    play.erase(play.begin(), play.begin() + static_cast<std::ptrdiff_t>(n));
    return static_cast<int>(n);
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    const std::string answer = service_.open ? "" : service_.feed({bytes.begin(), bytes.end()});
    play.insert(play.begin(), answer.begin(), answer.end());
    return true;
  }
  Nanos now() noexcept override { return t_; }

 private:
  test::HaplyService service_;
  Nanos t_ = 0;
  bool play_ended_ = true;
};

TEST(Parsers, AWebSocketWithInvalidFramesIsALostDevice) {
  Garbage garbage(6);
  for (int i = 0; i < 300; ++i) {
    auto link = std::make_unique<Player>();
    link->play = garbage.bytes(3000);
    WebSocket socket(std::move(link), "test", "/");
    std::string_view message;
    int messages = 0;
    while (socket.receive(message, 1'000'000) == WebSocket::Got::kMessage) {
      ASSERT_LE(message.size(), WebSocket::kLongestMessage);
      ++messages;
    }
    ASSERT_GE(messages, 1);  // the state that followed the handshake
  }
}

}  // namespace
}  // namespace typodont::haptics
