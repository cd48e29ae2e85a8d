// The state of a live session for other programs: displays, LSL bridges, data loggers. Over OSC and over WebSocket as
// JSON, as docs/doors/stream.md describes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/clock.h"
#include "engine/contract/contact.h"

namespace typodont {

/// What a reader is told once.
struct StreamedSession {
  std::string scene;               // its name
  std::vector<std::string> tools;  // ServoTick::tool counts into these
  double servo_rate = 1000;        // Hz
};

/// Sends to everyone who listens. All functions are called from one thread, never the servo's. None of them waits: a
/// reader that does not keep up loses messages, one that reads nothing, or sends no request, for
/// kPatience is cut off.
class StateStream {
 public:
  /// `addresses`: "osc:PORT", "osc:HOST:PORT" (messages are sent there), "ws:PORT", "ws:HOST:PORT" (readers connect
  /// there). Without a host it is this computer alone (127.0.0.1). Throws Error: an address that is none, a port in
  /// use.
  StateStream(const std::vector<std::string>& addresses, StreamedSession session);
  ~StateStream();
  StateStream(const StateStream&) = delete;
  StateStream& operator=(const StateStream&) = delete;

  /// The session's zero on the system's monotonic clock, ns; what follows is counted from there.
  void begin(Nanos zero);
  /// The newest tick; `lost`: ticks that the stream has missed so far.
  void state(const ServoTick& tick, std::uint64_t lost);
  /// `kind`: "tool", "fault", "end" …
  void event(Nanos t, const std::string& kind, const std::string& text);
  /// Lets readers in, answers them, sends what waits. Call it every few milliseconds.
  void turn();

  struct Counts {
    std::uint64_t readers = 0;  // connected now, over WebSocket
    std::uint64_t sent = 0;     // messages handed to the system
    std::uint64_t skipped = 0;  // messages that a slow reader did not get
    std::uint64_t cut_off = 0;  // readers that read nothing for too long
  };
  Counts counts() const;
  /// Port of the first address that readers connect to; 0: there is none. Of "ws:0" the system chooses it.
  int port() const;

  static constexpr Nanos kPatience = 5 * kNanosPerSecond;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
