// Publishes the state of a live session to other programs (displays, LSL bridges, data loggers) over OSC, and as JSON
// over WebSocket. docs/doors/stream.md describes the format.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/clock.h"
#include "engine/contract/contact.h"

namespace typodont {

/// Data about the session that every reader receives once.
struct StreamedSession {
  std::string scene;               // name of the scene
  std::vector<std::string> tools;  // names of the tools; ServoTick::tool is an index in this list
  double servo_rate = 1000;        // Hz, rate of the servo
};

/// Sends messages to all readers. All functions are called by one thread, which must not be the servo thread. No
/// function blocks; therefore a reader that is too slow loses messages. A reader is disconnected if, for the time
/// kPatience, it reads no data or does not complete its request.
class StateStream {
 public:
  /// `addresses`: "osc:PORT" or "osc:HOST:PORT", to which messages are sent; "ws:PORT" or "ws:HOST:PORT", to which
  /// readers connect. The default host is this computer (127.0.0.1). Throws Error if an address is invalid or its port
  /// is in use.
  StateStream(const std::vector<std::string>& addresses, StreamedSession session);
  ~StateStream();
  StateStream(const StateStream&) = delete;
  StateStream& operator=(const StateStream&) = delete;

  /// Sets the start of the session. `zero`: ns, time of the system's monotonic clock; later times are relative to it.
  void begin(Nanos zero);
  /// Publishes the latest tick. `lost`: number of ticks that the stream has not received so far.
  void state(const ServoTick& tick, std::uint64_t lost);
  /// Publishes an event. `kind`: for example "tool", "fault" or "end".
  void event(Nanos t, const std::string& kind, const std::string& text);
  /// Accepts readers, answers their requests, and sends waiting data. Call it every few milliseconds.
  void turn();

  struct Counts {
    std::uint64_t readers = 0;  // number of readers that are now connected by WebSocket
    std::uint64_t sent = 0;     // number of messages that were passed to the operating system
    std::uint64_t skipped = 0;  // number of messages that were not sent to slow readers
    std::uint64_t cut_off = 0;  // number of readers that were disconnected because they did not read
  };
  Counts counts() const;
  /// Returns the port of the first WebSocket address; 0 if there is none. For "ws:0" the system has chosen the port.
  int port() const;

  static constexpr Nanos kPatience = 5 * kNanosPerSecond;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
