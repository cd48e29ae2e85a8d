#include "engine/app/live/state_stream.h"

#include <fcntl.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <charconv>
#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>
#include <optional>
#include <queue>
#include <utility>
#ifdef TYPODONT_LIBLO
#include <lo/lo.h>
#endif

#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

using Text = nlohmann::ordered_json;
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using asio::ip::udp;
using ErrorCode = boost::system::error_code;

constexpr const char* kSchema = "typodont-state-1";
// Largest number of messages that wait for one reader. A further message is not sent to this reader.
constexpr std::size_t kMaxWaiting = 100;
constexpr std::uint32_t kMaxAsked = 1 << 13;  // bytes; a reader with a longer request is disconnected
constexpr std::size_t kMaxReaders = 32;
// Largest number of completed operations that are handled at once, because a reader may send endlessly.
constexpr int kMaxHandled = 256;

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

/// Programs that this process starts do not inherit the socket.
void close_on_exec(int socket) {
  ::fcntl(socket, F_SETFD, FD_CLOEXEC);
}

/// A reader's socket.
struct ReaderSocket : tcp::socket {
  explicit ReaderSocket(tcp::socket socket) : tcp::socket(std::move(socket)) {}
};
/// Called by Beast at the end of a connection. Beast's version for tcp::socket reads until the reader closes.
template <class Handler>
void async_teardown(beast::role_type, ReaderSocket& socket, Handler&& handler) {
  ErrorCode error;
  socket.close(error);
  asio::post(socket.get_executor(), beast::bind_front_handler(std::forward<Handler>(handler), error));
}

/// A program that is connected to the WebSocket. Each pending operation is an owner of its reader.
struct Reader {
  explicit Reader(tcp::socket socket) : stream(std::move(socket)) {
    stream.auto_fragment(false);  // simple readers expect a message in one frame
    request.header_limit(kMaxAsked);
  }
  bool connected() { return stream.next_layer().is_open(); }
  /// Ends the pending operations, with errors.
  void disconnect() {
    ErrorCode ignored;
    stream.next_layer().close(ignored);
  }

  beast::websocket::stream<ReaderSocket, /*deflateSupported=*/false> stream;
  beast::flat_buffer received;
  http::request_parser<http::empty_body> request;
  std::queue<std::string> waiting;  // messages that are not completely sent
  bool greeted = false;             // true: the WebSocket handshake is complete
  // Start of the time without progress: a message is not sent, or the request is incomplete. Empty: not stuck.
  std::optional<Nanos> stuck = now();
};
using ReaderPointer = std::shared_ptr<Reader>;

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
  asio::io_context io;  // owns the pending operations, so it is destroyed after the readers
  StreamedSession session;
  std::vector<udp::socket> osc;
  std::vector<tcp::acceptor> listening;
  std::vector<ReaderPointer> readers;
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
  void greet(const ReaderPointer& reader);
  void refuse(Reader& reader, http::status status);
  void listen_to(const ReaderPointer& reader);
  void tell(const ReaderPointer& reader, const std::string& text, bool may_skip);
  void send_next(const ReaderPointer& reader);
  void tell_all(const std::string& text, bool may_skip) {
    for (const ReaderPointer& reader : readers) {
      if (reader->greeted) tell(reader, text, may_skip);
    }
    advance();
  }
  /// Handles completed operations.
  void advance() {
    io.restart();
    for (int i = 0; i < kMaxHandled && io.poll_one() > 0; ++i) continue;
  }
#ifdef TYPODONT_LIBLO
  void send_osc(Nanos t, const std::vector<std::pair<const char*, lo_message>>& messages);
#endif
};

/// Answers the request for a WebSocket. Refuses web pages from other computers (header Origin).
void StateStream::Impl::greet(const ReaderPointer& reader) {
  const auto answer = [this, reader](ErrorCode unreadable, std::size_t) {
    if (unreadable) return refuse(*reader, http::status::bad_request);
    const auto& request = reader->request.get();
    const std::string origin(request[http::field::origin]);
    if (!origin.empty() && !is_local(origin)) return refuse(*reader, http::status::forbidden);
    reader->received.clear();
    reader->stream.async_accept(request, [this, reader](ErrorCode refused) {
      if (refused) return reader->disconnect();
      reader->greeted = true;
      tell(reader, hello(), /*may_skip=*/false);
      listen_to(reader);
    });
  };
  http::async_read_header(reader->stream.next_layer(), reader->received, reader->request, answer);
}

void StateStream::Impl::refuse(Reader& reader, http::status status) {
  http::response<http::empty_body> response(status, 11);
  response.keep_alive(false);
  response.prepare_payload();
  ErrorCode ignored;
  http::write(reader.stream.next_layer(), response, ignored);
  reader.disconnect();
}

/// Answers pings, ignores messages, and detects the end of the connection.
void StateStream::Impl::listen_to(const ReaderPointer& reader) {
  reader->stream.async_read_some(reader->received, kMaxAsked, [this, reader](ErrorCode ended, std::size_t) {
    if (ended) return reader->disconnect();
    reader->received.clear();
    listen_to(reader);
  });
}

void StateStream::Impl::tell(const ReaderPointer& reader, const std::string& text, bool may_skip) {
  // Events are rare and important: twice as many messages may wait.
  if (reader->waiting.size() >= (may_skip ? kMaxWaiting : 2 * kMaxWaiting)) {
    ++counts.skipped;
    return;
  }
  reader->waiting.push(text);
  ++counts.sent;
  if (reader->waiting.size() == 1) send_next(reader);
}

void StateStream::Impl::send_next(const ReaderPointer& reader) {
  reader->stuck = now();
  reader->stream.async_write(asio::buffer(reader->waiting.front()), [this, reader](ErrorCode failed, std::size_t) {
    if (failed) return reader->disconnect();
    reader->waiting.pop();
    reader->stuck.reset();
    if (!reader->waiting.empty()) send_next(reader);
  });
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
  for (udp::socket& to : osc) {
    ErrorCode lost;  // set if nobody listens, or if the system's buffer is full
    to.send(asio::buffer(bytes, size), 0, lost);
    ++(lost ? counts.skipped : counts.sent);
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
    try {
      if (address.osc) {
        udp::socket& socket = impl_->osc.emplace_back(impl_->io);
        socket.connect(udp::resolver(impl_->io).resolve(address.host, address.port).begin()->endpoint());
        socket.non_blocking(true);
        close_on_exec(socket.native_handle());
        continue;
      }
      tcp::acceptor& acceptor = impl_->listening.emplace_back(
          impl_->io, tcp::resolver(impl_->io).resolve(address.host, address.port).begin()->endpoint());
      acceptor.non_blocking(true);
      close_on_exec(acceptor.native_handle());
      if (impl_->port == 0) impl_->port = acceptor.local_endpoint().port();
    } catch (const boost::system::system_error& e) {
      throw Error("--stream", text, e.code().message(), "a host that is known, and a port that is free and allowed");
    }
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
  auto& readers = impl_->readers;
  for (tcp::acceptor& acceptor : impl_->listening) {
    for (;;) {
      ErrorCode error;
      tcp::socket socket = acceptor.accept(error);
      if (error) break;
      close_on_exec(socket.native_handle());
      socket.non_blocking(true, error);
      socket.set_option(tcp::no_delay(true), error);
      // If there are too many readers, a connection without a finished handshake is closed to make room.
      if (readers.size() >= kMaxReaders)
        if (const auto silent = std::ranges::find(readers, false, &Reader::greeted); silent != readers.end()) {
          (*silent)->disconnect();
          readers.erase(silent);
        }
      if (readers.size() < kMaxReaders) impl_->greet(readers.emplace_back(std::make_shared<Reader>(std::move(socket))));
    }
  }
  impl_->advance();
  for (const ReaderPointer& reader : readers) {
    if (!reader->connected() || !reader->stuck || now() - *reader->stuck <= kPatience) continue;
    reader->disconnect();
    ++impl_->counts.cut_off;
  }
  std::erase_if(readers, [](const ReaderPointer& reader) { return !reader->connected(); });
}

StateStream::Counts StateStream::counts() const {
  Counts counts = impl_->counts;
  counts.readers = static_cast<std::uint64_t>(std::ranges::count(impl_->readers, true, &Reader::greeted));
  return counts;
}

int StateStream::port() const {
  return impl_->port;
}

}  // namespace typodont
