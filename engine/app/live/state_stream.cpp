#include "engine/app/live/state_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#ifdef TYPODONT_LIBLO
#include <lo/lo.h>
#endif

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/websocket.h"

namespace typodont {

namespace {

using Text = nlohmann::ordered_json;

constexpr const char* kSchema = "typodont-state-1";
// Largest amount of data that waits for one reader, bytes: about 100 messages. A message that would exceed this amount
// is not sent to this reader.
constexpr std::size_t kMaxWaiting = 1 << 16;
constexpr std::size_t kMaxAsked = 1 << 13;  // bytes; a reader with a longer request is disconnected
constexpr std::size_t kMaxReaders = 32;

/// A socket whose calls never block.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int fd) : fd_(fd) {
    if (fd >= 0) ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
  }
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int get() const { return fd_; }

 private:
  int fd_ = -1;
};

struct Address {
  bool osc = false;
  std::string host = "127.0.0.1", port;
};

Address read_address(const std::string& text) {
  const auto bad = [&] { return Error("--stream", "", text, "osc:[HOST:]PORT or ws:[HOST:]PORT"); };
  Address address;
  std::string rest;
  if (text.starts_with("osc:")) {
    address.osc = true;
    rest = text.substr(4);
  } else if (text.starts_with("ws:")) {
    rest = text.substr(3);
  } else {
    throw bad();
  }
  if (const std::size_t colon = rest.rfind(':'); colon != std::string::npos) {
    address.host = rest.substr(0, colon);
    rest.erase(0, colon + 1);
  }
  unsigned port = 0;
  const auto read = std::from_chars(rest.data(), rest.data() + rest.size(), port);
  if (read.ec != std::errc() || read.ptr != rest.data() + rest.size() || port > 65535 || (address.osc && port == 0) ||
      address.host.empty())
    throw bad();
  address.port = rest;
  return address;
}

/// Opens a connected socket (UDP) or a listening one (TCP).
Socket open_socket(const Address& address, const std::string& text) {
  addrinfo hints{};
  hints.ai_socktype = address.osc ? SOCK_DGRAM : SOCK_STREAM;
  hints.ai_flags = address.osc ? 0 : AI_PASSIVE;
  addrinfo* found = nullptr;
  if (const int code = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); code != 0)
    throw Error("--stream", text, ::gai_strerror(code), "a host that is known");
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  Socket socket(::socket(found->ai_family, found->ai_socktype | SOCK_CLOEXEC, 0));
  const int yes = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const bool done = socket.get() >= 0 && (address.osc ? ::connect(socket.get(), found->ai_addr, found->ai_addrlen) == 0
                                                      : ::bind(socket.get(), found->ai_addr, found->ai_addrlen) == 0 &&
                                                            ::listen(socket.get(), 8) == 0);
  if (!done) throw Error("--stream", text, std::strerror(errno), "a port that is free and allowed");
  return socket;
}

/// A program that is connected to the WebSocket.
struct Reader {
  Socket socket;
  std::string asked;     // the part of the request that has arrived
  std::string waiting;   // data that is not yet sent
  bool greeted = false;  // true: the WebSocket handshake is complete
  // Start of the time without progress: the reader receives nothing, or its request is incomplete. Empty: not stuck.
  std::optional<Nanos> stuck;
  bool gone = false;
};

/// True for an origin scheme://host[:port] on this computer. "null" is refused, because a frame in any web page can
/// have it.
bool is_local(std::string_view origin) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    for (const std::string_view host : {"localhost", "127.0.0.1", "[::1]"}) {
      const std::string_view rest = origin.substr(scheme.size());
      if (rest.starts_with(host) && (rest.size() == host.size() || rest[host.size()] == ':')) return true;
    }
  }
  return false;
}

std::string state_text(const ServoTick& tick, const StreamedSession& session, std::uint64_t lost) {
  const auto vec = [](const dvec3& v, double unit) { return Text{v.x / unit, v.y / unit, v.z / unit}; };
  const auto turn = [](const dquat& q) { return Text{q.w, q.x, q.y, q.z}; };
  Text removed = Text::object();
  for (std::size_t i = 1; i < tick.removed.size(); ++i) {
    if (tick.removed[i] != 0)
      removed[std::string(name_of(static_cast<Tissue>(i)))] = tick.removed[i] / kCubicMillimetre;
  }
  const Text text{{"type", "state"},
                  {"t_s", to_seconds(tick.t)},
                  {"tick", tick.index},
                  {"hand_mm", vec(tick.X_WT.p, kMillimetre)},
                  {"hand_q", turn(tick.X_WT.R)},
                  {"tool_mm", vec(tick.X_WG.p, kMillimetre)},
                  {"tool_q", turn(tick.X_WG.R)},
                  {"force_N", vec(tick.f_T_W, 1)},
                  {"torque_Nmm", vec(tick.tau_T_W, kMillimetre)},
                  {"depth_mm", tick.depth / kMillimetre},
                  {"normal", vec(tick.n_C_W, 1)},
                  {"contact_area_mm2", tick.contact_area / kSquareMillimetre},
                  {"cutting_power_W", tick.cutting_power},
                  {"tissue", name_of(tick.tissue)},
                  {"removed_mm3", std::move(removed)},
                  {"spindle_krpm", tick.spindle / kKrpm},
                  {"pedal", tick.pedal},
                  {"tool", tick.tool < session.tools.size() ? session.tools[tick.tool] : ""},
                  {"wear", tick.wear},
                  {"faults", tick.faults},
                  {"lost", lost}};
  return text.dump();
}

}  // namespace

struct StateStream::Impl {
  StreamedSession session;
  std::vector<Socket> osc, listening;
  std::vector<Reader> readers;
  Counts counts;
  Nanos zero = 0;       // ns, monotonic clock at session time zero
  Nanos unix_zero = 0;  // ns since 1970 (UTC) at session time zero
  int port = 0;

  std::string hello() const {
    return Text{{"type", "hello"},
                {"schema", kSchema},
                {"scene", session.scene},
                {"tools", session.tools},
                {"servo_Hz", session.servo_rate},
                {"sound",
                 {{"model", session.voice.model},
                  {"free_speed_krpm", session.voice.free_speed / kKrpm},
                  {"tools_cut", session.voice.tools_cut}}},
                {"clock", {{"zero_unix_ns", unix_zero}, {"zero_monotonic_ns", zero}}}}
        .dump(-1, ' ', false, Text::error_handler_t::replace);
  }
  void tell(Reader& reader, const std::string& text, bool may_skip);
  void tell_all(const std::string& text, bool may_skip) {
    for (Reader& reader : readers) {
      if (reader.greeted) tell(reader, text, may_skip);
    }
  }
  void flush(Reader& reader);
  void listen_to(Reader& reader);
  void answer(Reader& reader);
#ifdef TYPODONT_LIBLO
  void send_osc(Nanos t, const std::vector<std::pair<const char*, lo_message>>& messages);
#endif
};

void StateStream::Impl::tell(Reader& reader, const std::string& text, bool may_skip) {
  const std::string frame = websocket_text_frame(text);
  // Events are rare and important: they may use twice kMaxWaiting.
  if (reader.waiting.size() + frame.size() > (may_skip ? kMaxWaiting : 2 * kMaxWaiting)) {
    ++counts.skipped;
    return;
  }
  reader.waiting += frame;
  ++counts.sent;
  flush(reader);
}

void StateStream::Impl::flush(Reader& reader) {
  while (!reader.waiting.empty()) {
    const ssize_t n = ::send(reader.socket.get(), reader.waiting.data(), reader.waiting.size(), MSG_NOSIGNAL);
    if (n > 0) {
      reader.waiting.erase(0, static_cast<std::size_t>(n));
      reader.stuck.reset();
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK) reader.gone = true;
    if (!reader.stuck) reader.stuck = now();
    return;
  }
}

/// Answers a WebSocket handshake (RFC 6455, 4.2). Refuses web pages from other computers (header Origin).
void StateStream::Impl::answer(Reader& reader) {
  const std::size_t end = reader.asked.find("\r\n\r\n");
  if (end == std::string::npos) {
    if (reader.asked.size() > kMaxAsked) reader.gone = true;
    return;
  }
  const auto field = [&](std::string_view name) -> std::string {
    for (std::size_t at = reader.asked.find("\r\n"); at < end; at = reader.asked.find("\r\n", at + 2)) {
      const std::size_t start = at + 2, stop = std::min(reader.asked.find("\r\n", start), end);
      if (stop - start < name.size() + 1 || reader.asked[start + name.size()] != ':' ||
          strncasecmp(reader.asked.data() + start, name.data(), name.size()) != 0)
        continue;
      std::string value = reader.asked.substr(start + name.size() + 1, stop - start - name.size() - 1);
      value.erase(0, value.find_first_not_of(" \t"));
      value.erase(value.find_last_not_of(" \t") + 1);
      return value;
    }
    return "";
  };
  const std::string key = field("Sec-WebSocket-Key"), origin = field("Origin");
  const bool local = origin.empty() || is_local(origin);
  if (!reader.asked.starts_with("GET ") || key.empty() || !local) {
    reader.waiting = local ? "HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
                           : "HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
    flush(reader);
    reader.gone = true;
    return;
  }
  reader.asked.erase(0, end + 4);
  reader.waiting =
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: " +
      websocket_accept(key) + "\r\n\r\n";
  reader.greeted = true;
  tell(reader, hello(), /*may_skip=*/false);
}

/// Reads from a reader's connection: first the reader's request; after the handshake, only WebSocket control frames.
void StateStream::Impl::listen_to(Reader& reader) {
  char buffer[4096];
  constexpr int kMaxReads = 16;  // largest number of reads per call, because a reader may send endlessly
  for (int i = 0; i < kMaxReads; ++i) {
    const ssize_t n = ::recv(reader.socket.get(), buffer, sizeof buffer, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
    constexpr char kClose = '\x88';
    if (n <= 0 || (reader.greeted && buffer[0] == kClose)) {
      reader.gone = true;
      return;
    }
    if (reader.greeted) continue;
    reader.asked.append(buffer, static_cast<std::size_t>(n));
    answer(reader);
    if (reader.gone) return;
  }
}

#ifdef TYPODONT_LIBLO
void StateStream::Impl::send_osc(Nanos t, const std::vector<std::pair<const char*, lo_message>>& messages) {
  // NTP time counts from 1900, in units of 2^-32 s.
  constexpr std::uint64_t kFrom1900To1970 = 2'208'988'800;
  const auto at = static_cast<std::uint64_t>(unix_zero + t);
  const lo_timetag time{static_cast<std::uint32_t>(at / kNanosPerSecond + kFrom1900To1970),
                        static_cast<std::uint32_t>((at % kNanosPerSecond << 32) / kNanosPerSecond)};
  lo_bundle bundle = lo_bundle_new(time);
  for (const auto& [path, message] : messages) lo_bundle_add_message(bundle, path, message);
  std::size_t size = 0;
  void* const bytes = lo_bundle_serialise(bundle, nullptr, &size);
  for (const Socket& to : osc) {
    // The message is lost if nobody listens, or if the system's buffer is full.
    if (::send(to.get(), bytes, size, MSG_NOSIGNAL) == static_cast<ssize_t>(size))
      ++counts.sent;
    else
      ++counts.skipped;
  }
  std::free(bytes);
  lo_bundle_free_recursive(bundle);
}
#endif

StateStream::StateStream(const std::vector<std::string>& addresses, StreamedSession session)
    : impl_(std::make_unique<Impl>()) {
  impl_->session = std::move(session);
  for (const std::string& text : addresses) {
    const Address address = read_address(text);
#ifndef TYPODONT_LIBLO
    if (address.osc) throw Error("--stream", "", text, "ws:[HOST:]PORT: this program was built without liblo");
#endif
    (address.osc ? impl_->osc : impl_->listening).push_back(open_socket(address, text));
    if (address.osc || impl_->port != 0) continue;
    sockaddr_storage own{};
    socklen_t size = sizeof own;
    ::getsockname(impl_->listening.back().get(), reinterpret_cast<sockaddr*>(&own), &size);
    impl_->port = ntohs(own.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(own).sin6_port
                                                  : reinterpret_cast<sockaddr_in&>(own).sin_port);
  }
}
StateStream::~StateStream() = default;

void StateStream::begin(Nanos zero) {
  timespec t{};
  ::clock_gettime(CLOCK_REALTIME, &t);
  impl_->zero = zero;
  impl_->unix_zero = static_cast<Nanos>(t.tv_sec) * kNanosPerSecond + t.tv_nsec - (now() - zero);
  impl_->tell_all(impl_->hello(), /*may_skip=*/false);
}

void StateStream::state(const ServoTick& tick, std::uint64_t lost) {
  if (!impl_->readers.empty()) impl_->tell_all(state_text(tick, impl_->session, lost), /*may_skip=*/true);
#ifdef TYPODONT_LIBLO
  if (impl_->osc.empty()) return;
  const auto vec = [](const dvec3& v, double unit) {
    lo_message m = lo_message_new();
    for (int i = 0; i < 3; ++i) lo_message_add_float(m, static_cast<float>(v[i] / unit));
    return m;
  };
  const auto pose = [&](const Pose& X) {
    lo_message m = vec(X.p, kMillimetre);
    for (const double v : {X.R.w, X.R.x, X.R.y, X.R.z}) lo_message_add_float(m, static_cast<float>(v));
    return m;
  };
  const auto number = [](double v) {
    lo_message m = lo_message_new();
    lo_message_add_float(m, static_cast<float>(v));
    return m;
  };
  const auto text = [](std::string_view s) {
    lo_message m = lo_message_new();
    lo_message_add_string(m, std::string(s).c_str());
    return m;
  };
  lo_message time = lo_message_new();
  lo_message_add_double(time, to_seconds(tick.t));
  lo_message faults = lo_message_new();
  lo_message_add_int32(faults, static_cast<std::int32_t>(tick.faults));
  const double removed = total(tick.removed);
  impl_->send_osc(tick.t, {{"/typodont/time", time},
                           {"/typodont/hand", pose(tick.X_WT)},
                           {"/typodont/tool", pose(tick.X_WG)},
                           {"/typodont/force", vec(tick.f_T_W, 1)},
                           {"/typodont/depth", number(tick.depth / kMillimetre)},
                           {"/typodont/tissue", text(name_of(tick.tissue))},
                           {"/typodont/removed", number(removed / kCubicMillimetre)},
                           {"/typodont/spindle", number(tick.spindle / kKrpm)},
                           {"/typodont/pedal", number(tick.pedal)},
                           {"/typodont/faults", faults}});
#endif
}

void StateStream::event(Nanos t, const std::string& kind, const std::string& text) {
  impl_->tell_all(Text{{"type", "event"}, {"t_s", to_seconds(t)}, {"kind", kind}, {"text", text}}.dump(
                      -1, ' ', false, Text::error_handler_t::replace),
                  /*may_skip=*/false);
#ifdef TYPODONT_LIBLO
  if (impl_->osc.empty()) return;
  lo_message m = lo_message_new();
  lo_message_add_double(m, to_seconds(t));
  lo_message_add_string(m, kind.c_str());
  lo_message_add_string(m, text.c_str());
  impl_->send_osc(t, {{"/typodont/event", m}});
#endif
}

void StateStream::turn() {
  for (const Socket& listening : impl_->listening) {
    for (int fd; (fd = ::accept4(listening.get(), nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) {
      Reader reader{Socket(fd), "", "", false, now(), false};
      const int yes = 1;
      ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      // If there are too many readers, a connection without a finished handshake is closed to make room.
      if (impl_->readers.size() >= kMaxReaders)
        if (const auto silent = std::ranges::find(impl_->readers, false, &Reader::greeted);
            silent != impl_->readers.end())
          impl_->readers.erase(silent);
      if (impl_->readers.size() < kMaxReaders) impl_->readers.push_back(std::move(reader));
    }
  }
  for (Reader& reader : impl_->readers) {
    impl_->listen_to(reader);
    if (!reader.gone) impl_->flush(reader);
    if (!reader.gone && reader.stuck && now() - *reader.stuck > kPatience) {
      reader.gone = true;
      ++impl_->counts.cut_off;
    }
  }
  std::erase_if(impl_->readers, [](const Reader& reader) { return reader.gone; });
}

StateStream::Counts StateStream::counts() const {
  Counts counts = impl_->counts;
  counts.readers = static_cast<std::uint64_t>(
      std::count_if(impl_->readers.begin(), impl_->readers.end(), [](const Reader& r) { return r.greeted; }));
  return counts;
}

int StateStream::port() const {
  return impl_->port;
}

}  // namespace typodont
