// Publishes the state of a live session to other programs (displays, LSL bridges, data loggers): over OSC, and as JSON
// over WebSocket. docs/doors/stream.md describes the format.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/clock.h"
#include "engine/contract/contact.h"

namespace typodont {

/// Data about the session. Every reader gets it once.
struct StreamedSession {
  std::string scene;               // name of the scene
  std::vector<std::string> tools;  // names of the tools; ServoTick::tool is an index into them
  double servo_rate = 1000;        // Hz
};

/// Sends messages to all readers. One thread calls all functions; it must not be the servo thread. No function waits,
/// so a slow reader loses messages. A reader that reads nothing, or sends no request, for kPatience is disconnected.
class StateStream {
 public:
  /// `addresses`: "osc:PORT" or "osc:HOST:PORT", to which messages are sent; "ws:PORT" or "ws:HOST:PORT", to which
  /// readers connect. The default host is this computer (127.0.0.1). Throws Error for an invalid address or a port in
  /// use.
  StateStream(const std::vector<std::string>& addresses, StreamedSession session);
  ~StateStream();
  StateStream(const StateStream&) = delete;
  StateStream& operator=(const StateStream&) = delete;

  /// Sets the time on the system's monotonic clock, ns, at which the session's time is zero; later times are relative
  /// to it.
  void begin(Nanos zero);
  /// Publishes the latest tick; `lost`: number of ticks that the stream has missed so far.
  void state(const ServoTick& tick, std::uint64_t lost);
  /// Publishes an event; `kind` is for example "tool", "fault" or "end".
  void event(Nanos t, const std::string& kind, const std::string& text);
  /// Accepts readers, answers their requests, and sends waiting data. Call it every few milliseconds.
  void turn();

  struct Counts {
    std::uint64_t readers = 0;  // number of readers that are now connected by WebSocket
    std::uint64_t sent = 0;     // number of messages passed to the system
    std::uint64_t skipped = 0;  // number of messages that slow readers did not get
    std::uint64_t cut_off = 0;  // number of readers that were disconnected because they did not read
  };
  Counts counts() const;
  /// Port of the first WebSocket address; 0: none. For "ws:0" the system chooses the port.
  int port() const;

  static constexpr Nanos kPatience = 5 * kNanosPerSecond;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
