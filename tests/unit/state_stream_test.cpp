// Tests the state of a session for other programs, with real sockets on this computer.
#include "engine/app/live/state_stream.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/app/live/session.h"
#include "engine/app/live/sound_follower.h"
#include "engine/app/recording/resume.h"
#include "engine/base/error.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

using Messages = std::vector<nlohmann::json>;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A program that listens over WebSocket.
class Client {
 public:
  explicit Client(int port) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    // The buffer is so small that it is full soon if the reader does not read.
    const int size = 4096;
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
    const sockaddr_in address = loopback(port);
    EXPECT_EQ(::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Client() { ::close(fd_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void say(const std::string& text) { EXPECT_EQ(::send(fd_, text.data(), text.size(), 0), ssize_t(text.size())); }
  void greet(const std::string& more = "") {
    say("GET / HTTP/1.1\r\nHost: here\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" + more +
        "sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n");
  }
  /// Sends as many empty messages as fit now. A real reader has nothing to say.
  void chatter() {
    constexpr std::string_view kMessage("\x81\x80\0\0\0\0", 6);  // masked, as from every client
    std::string text;
    while (text.size() < 65536) text += kMessage;
    const ssize_t n = ::send(fd_, text.data() + said_, text.size() - said_, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n > 0) said_ = (said_ + static_cast<std::size_t>(n)) % kMessage.size();
  }
  /// What is there to be read now.
  void read() {
    char buffer[65536];
    for (ssize_t n; (n = ::recv(fd_, buffer, sizeof buffer, MSG_DONTWAIT)) > 0;) in_.append(buffer, std::size_t(n));
  }
  /// The status line of the answer.
  std::string status() {
    read();
    return in_.substr(0, in_.find("\r\n"));
  }
  /// Returns the complete messages that came after the handshake.
  Messages messages() {
    read();
    const std::size_t head = in_.find("\r\n\r\n");
    Messages found;
    if (head == std::string::npos) return found;
    for (std::size_t at = head + 4; at + 2 <= in_.size();) {
      std::size_t size = static_cast<unsigned char>(in_[at + 1]), begin = at + 2;
      if (size == 126) {
        size = static_cast<unsigned char>(in_[at + 2]) << 8 | static_cast<unsigned char>(in_[at + 3]);
        begin += 2;
      }
      if (begin + size > in_.size()) break;
      found.push_back(nlohmann::json::parse(in_.substr(begin, size)));
      at = begin + size;
    }
    return found;
  }

 private:
  int fd_;
  std::string in_;
  std::size_t said_ = 0;  // bytes of the last message that chatter() has sent
};

/// Gives the stream turns until `done` returns true, because data needs some time even over loopback.
template <class Done>
void turn_until(StateStream& stream, Done&& done) {
  for (int i = 0; i < 20'000 && !done(); ++i) {
    stream.turn();
    ::usleep(500);
  }
}

ServoTick a_tick(Nanos t) {
  ServoTick tick;
  tick.t = t;
  tick.index = static_cast<std::uint64_t>(t / 1'000'000);
  tick.f_T_W = {0.25, 0, 1.5};
  tick.X_WG.p = {1e-3, 2e-3, 3e-3};
  tick.removed[static_cast<std::size_t>(Tissue::kEnamel)] = 2e-9;
  tick.tissue = Tissue::kEnamel;
  return tick;
}

const StreamedSession kSession{"a scene", {"round_012"}, 1000, {"air_turbine", 400 * kKrpm, {true}}};

TEST(StateStream, AReaderGetsTheSessionThenStatesAndEventsInOrder) {
  StateStream stream({"ws:0"}, kSession);
  Client client(stream.port());
  client.greet();
  turn_until(stream, [&] { return stream.counts().readers == 1; });
  stream.begin(now());
  stream.state(a_tick(5'000'000), 3);
  stream.event(6'000'000, "fault", "stale_patch");
  Messages found;
  turn_until(stream, [&] { return (found = client.messages()).size() >= 4; });
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(client.status(), "HTTP/1.1 101 Switching Protocols");
  EXPECT_EQ(found[0]["schema"], "typodont-state-1");
  EXPECT_EQ(found[1]["scene"], "a scene");
  EXPECT_GT(found[1]["clock"]["zero_unix_ns"].get<std::int64_t>(), 1'600'000'000'000'000'000);
  EXPECT_EQ(found[2]["type"], "state");
  EXPECT_EQ(found[2]["t_s"], 0.005);
  EXPECT_EQ(found[2]["force_N"], nlohmann::json({0.25, 0.0, 1.5}));
  EXPECT_DOUBLE_EQ(found[2]["removed_mm3"]["enamel"].get<double>(), 2);
  EXPECT_EQ(found[2]["tissue"], "enamel");
  EXPECT_EQ(found[2]["tool"], "round_012");
  EXPECT_EQ(found[2]["lost"], 3);
  EXPECT_EQ(found[3]["text"], "stale_patch");
}

TEST(StateStream, ASessionSoundsOnAnotherComputerAsOnItsOwn) {
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return "wav:" + (folder.path() / name).string(); };
  StateStream stream({"ws:0"}, kSession);
  FollowedSound heard;
  std::thread other(
      [&] { heard = follow_sound({.address = "ws:" + std::to_string(stream.port()), .audio = file("there.wav")}); });
  turn_until(stream, [&] { return stream.counts().readers == 1; });
  const Nanos first = 2 * kNanosPerSecond;
  stream.begin(now() - first);
  EventLogs event_logs;
  SoundLink link(file("here.wav"), kSession.voice, event_logs, /*live=*/false, /*binaural=*/false, first);
  ServoTick tick;
  for (std::uint64_t i = 0; i < 300; ++i) {
    tick = a_tick(first + static_cast<Nanos>(i) * 1'000'000);
    tick.spindle = 350 * kKrpm;
    tick.pedal = 1;
    tick.n_C_W = {0, 0, 1};
    tick.contact_area = i < 150 ? 0 : 3e-6;
    tick.cutting_power = 2;
    tick.removed[static_cast<std::size_t>(Tissue::kEnamel)] += i < 150 ? 0 : 1e-12 * static_cast<double>(i - 150);
    stream.state(tick, 0);
    stream.turn();
    event_logs.servo.write(tick);
    ::usleep(500);
  }
  stream.event(tick.t, "end", "");
  turn_until(stream, [&] { return stream.counts().readers == 0; });
  other.join();
  link.stop(tick.t - first);
  EXPECT_EQ(stream.counts().skipped, 0u);
  EXPECT_EQ(heard.scene, "a scene");
  EXPECT_EQ(heard.states, 300u);
  const auto bytes = [&](const char* name) { return test::read_text(folder.path() / name); };
  EXPECT_GT(bytes("there.wav").size(), 20000u);
  EXPECT_EQ(bytes("there.wav"), bytes("here.wav"));
}

TEST(StateStream, AFollowerRefusesWhatIsNoStreamOfASession) {
  for (const char* address : {"9001", "ws:", "ws:x", "osc:9001", "ws:70000"})
    EXPECT_THROW(follow_sound({.address = address, .audio = "wav:/tmp/x.wav"}), Error) << address;
  StreamedSession forged = kSession;
  forged.voice.model = "../rigs/film";
  StateStream stream({"ws:0"}, forged);
  std::string said;
  std::atomic<bool> done{false};
  std::thread other([&] {
    try {
      follow_sound({.address = "ws:" + std::to_string(stream.port()), .audio = "wav:/tmp/x.wav"});
    } catch (const Error& e) {
      said = e.what();
    }
    done = true;
  });
  turn_until(stream, [&] { return stream.counts().readers == 1; });
  stream.state(a_tick(5'000'000), 0);
  turn_until(stream, [&] { return done.load(); });
  other.join();
  EXPECT_NE(said.find("../rigs/film"), std::string::npos) << said;
}

TEST(StateStream, AReaderThatNeverReadsLosesMessagesAndDelaysNeitherTheSenderNorAnotherReader) {
  StateStream stream({"ws:0"}, kSession);
  Client dead(stream.port()), alive(stream.port());
  dead.greet();
  alive.greet();
  turn_until(stream, [&] { return stream.counts().readers == 2; });
  stream.begin(now());
  // These are far more messages than the buffers of the system hold. If the sender waited for the reader that does not
  // read, this loop would never end.
  constexpr int kStates = 20'000;
  for (int i = 1; i <= kStates; ++i) {
    stream.state(a_tick(i * Nanos{1'000'000}), 0);
    if (i % 16 == 0) stream.turn(), alive.read();
  }
  EXPECT_GT(stream.counts().skipped, 1000u);
  turn_until(stream, [&] { return alive.messages().back().value("tick", 0) == kStates; });
  EXPECT_EQ(alive.messages().back()["tick"], kStates);
}

TEST(StateStream, AReaderThatIsGoneOrSpeaksNoWebSocketIsDisconnected) {
  StateStream stream({"ws:0"}, kSession);
  {
    Client client(stream.port());
    client.greet();
    turn_until(stream, [&] { return stream.counts().readers == 1; });
  }
  turn_until(stream, [&] { return stream.counts().readers == 0; });
  EXPECT_EQ(stream.counts().readers, 0u);
  Client nonsense(stream.port());
  nonsense.say("PUT / HTTP/1.1\r\n\r\n");
  turn_until(stream, [&] { return !nonsense.status().empty(); });
  EXPECT_EQ(nonsense.status(), "HTTP/1.1 400 Bad Request");
}

TEST(StateStream, ConnectionsThatAskForNothingDoNotKeepAReaderAway) {
  StateStream stream({"ws:0"}, kSession);
  std::vector<std::unique_ptr<Client>> silent;
  for (int i = 0; i < 40; ++i) {
    silent.push_back(std::make_unique<Client>(stream.port()));
    stream.turn();
  }
  Client client(stream.port());
  client.greet();
  const Nanos begin = now();
  turn_until(stream, [&] { return stream.counts().readers == 1; });
  EXPECT_EQ(client.status(), "HTTP/1.1 101 Switching Protocols");
  EXPECT_LT(now() - begin, kNanosPerSecond / 2);
}

TEST(StateStream, AWebPageFromAnotherOriginIsRefused) {
  StateStream stream({"ws:0"}, kSession);
  const auto status_of = [&](const std::string& origin) {
    Client client(stream.port());
    client.greet("Origin: " + origin + "\r\n");
    turn_until(stream, [&] { return !client.status().empty(); });
    return client.status();
  };
  for (const char* elsewhere : {"https://example.org", "http://localhost.example.org",
                                "http://127.0.0.1.example.org:80", "null", "file://localhost", "localhost"})
    EXPECT_EQ(status_of(elsewhere), "HTTP/1.1 403 Forbidden") << elsewhere;
  for (const char* here : {"http://localhost", "http://localhost:8000", "https://127.0.0.1:8443", "http://[::1]:8000"})
    EXPECT_EQ(status_of(here), "HTTP/1.1 101 Switching Protocols") << here;
}

TEST(StateStream, AReaderThatSendsContinuouslyDelaysNobody) {
  StateStream stream({"ws:0"}, kSession);
  Client loud(stream.port()), quiet(stream.port());
  loud.greet();
  quiet.greet();
  turn_until(stream, [&] { return stream.counts().readers == 2; });
  std::jthread talk([&](const std::stop_token& over) {
    while (!over.stop_requested()) loud.chatter();
  });
  stream.begin(now());
  for (int i = 1; i <= 200; ++i) {
    stream.state(a_tick(i * Nanos{1'000'000}), 0);
    stream.turn();
  }
  turn_until(stream, [&] { return !quiet.messages().empty() && quiet.messages().back().value("tick", 0) == 200; });
  EXPECT_EQ(quiet.messages().back()["tick"], 200);
}

TEST(StateStream, ALongMessageIsOneFrame) {
  StreamedSession session = kSession;
  session.tools.assign(1000, "round_012");
  StateStream stream({"ws:0"}, session);
  Client client(stream.port());
  client.greet();
  Messages found;
  turn_until(stream, [&] { return !(found = client.messages()).empty(); });
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0]["tools"].size(), 1000u);
}

TEST(StateStream, AnInvalidAddressOrOneInUseIsAnError) {
  for (const char* bad : {"", "ws", "ws:", "http:80", "ws:70000", "ws:12x", "osc:0", "osc:", "ws::80"})
    EXPECT_THROW(StateStream({bad}, kSession), Error) << bad;
  StateStream stream({"ws:0"}, kSession);
  EXPECT_THROW(StateStream({"ws:" + std::to_string(stream.port())}, kSession), Error);
}

#ifdef TYPODONT_LIBLO
TEST(StateStream, OscSendsTheStateInOneBundleWithTheTimeOfTheTick) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address = loopback(0);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  StateStream stream({"osc:" + std::to_string(ntohs(address.sin_port))}, kSession);
  stream.begin(now());
  stream.state(a_tick(5'000'000), 0);
  char buffer[4096];
  const ssize_t n = ::recv(fd, buffer, sizeof buffer, 0);
  ::close(fd);
  ASSERT_GT(n, 16);
  const std::string bundle(buffer, static_cast<std::size_t>(n));
  EXPECT_EQ(bundle.substr(0, 8), std::string("#bundle\0", 8));
  const auto word = [&](std::size_t at) {
    std::uint32_t v;
    std::memcpy(&v, bundle.data() + at, 4);
    return ntohl(v);
  };
  EXPECT_GT(word(8), 2'208'988'800u + 1'600'000'000u) << "seconds since 1900";
  const std::size_t force = bundle.find("/typodont/force");
  ASSERT_NE(force, std::string::npos);
  EXPECT_EQ(bundle.substr(force + 16, 4), ",fff");
  EXPECT_EQ(std::bit_cast<float>(word(force + 24)), 0.25f);
  EXPECT_EQ(std::bit_cast<float>(word(force + 32)), 1.5f);
}
#endif

/// Goes down into a block and stays.
class DownHand final : public haptics::HapticDevice {
 public:
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override {
    sample = {t_, {{0, 0, std::max(1.3e-3, 2e-3 - 1e-12 * static_cast<double>(t_))}}, 1, 0};
    t_ += 1'000'000;
    return true;
  }
  void write(const dvec3&, const dvec3&) noexcept override {}

 private:
  haptics::DeviceInfo info_;
  Nanos t_ = 0;
};

constexpr const char* kBlock = R"({"tissue": {"voxel_mm": 0.1, "solids": [
  {"tissue": "enamel", "solid": {"box": {"size_mm": [4, 4, 2]}}}]}, "tool": "round_012", "spindle_krpm": 300})";

TEST(StateStream, AStalledStreamDelaysNoTickAndItsLostMessagesAreCounted) {
  const Scene scene = parse_scene(Json::parse(kBlock, "scene"), "scene.json");
  LiveSession s(scene, load_tissue(scene));
  DownHand hand;
  s.serve(hand.info());
  StateStream stream({"ws:0"}, kSession);
  StreamTurns turns(s, stream, 100);
  s.wiring.patch.offer(s.carver, {0, 0, 2e-3});
  ServoTurns servo(s, hand);
  CarverTurns carver(s);
  constexpr std::uint64_t kTicks = 1 << 16;  // with their cuts, more than the tape keeps
  for (std::uint64_t i = 0; i < kTicks; ++i) {
    ASSERT_TRUE(servo.turn());
    carver.turn();
  }
  EXPECT_EQ(s.last.index + 1, kTicks);
  ServoEvent kept;
  EventLog<ServoEvent>::Reader reader(s.wiring.event_logs.servo);
  while (reader.next(kept) && !std::holds_alternative<ServoTick>(kept)) continue;
  const std::uint64_t lost = std::get<ServoTick>(kept).index;
  EXPECT_GT(lost, 100u);

  Client client(stream.port());
  client.greet();
  turn_until(stream, [&] { return stream.counts().readers == 1; });
  turns.turn();
  turns.end();
  Messages found;
  // The event of a fault comes before; on a busy machine, it may come alone.
  turn_until(stream, [&] { return !(found = client.messages()).empty() && found.back()["kind"] == "end"; });
  EXPECT_EQ(found.back()["kind"], "end");
  EXPECT_EQ(found[found.size() - 2]["lost"], lost);
}

}  // namespace
}  // namespace typodont
