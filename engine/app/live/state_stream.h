// Sends a live session's state to other programs, by OSC, and as JSON over WebSocket (docs/doors/stream.md).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/app/sound_link.h"
#include "engine/base/clock.h"
#include "engine/contract/contact.h"

namespace typodont {

/// Data that each reader receives once.
struct StreamedSession {
  std::string scene;               // name of the scene
  std::vector<std::string> tools;  // tool names; ServoTick::tool is an index into this list
  double servo_rate = 1000;        // Hz, rate of the servo
  SoundVoice voice;                // data from which another computer can make the session's sound
};

/// A single thread, which is not the servo thread, calls all functions. No function blocks, so slow readers lose
/// messages. A reader that neither reads nor completes its request is disconnected after kPatience.
class StateStream {
 public:
  /// Addresses: "osc:PORT" or "osc:HOST:PORT" receive messages; readers connect to "ws:PORT" or "ws:HOST:PORT". Default
  /// host: 127.0.0.1. Throws Error if an address is invalid or in use.
  StateStream(const std::vector<std::string>& addresses, StreamedSession session);
  ~StateStream();
  StateStream(const StateStream&) = delete;
  StateStream& operator=(const StateStream&) = delete;

  /// Starts the session's clock. `zero`: time of the monotonic clock to which later times are relative, ns.
  void begin(Nanos zero);
  /// Sends a tick. `lost`: number of ticks that the stream has missed so far.
  void state(const ServoTick& tick, std::uint64_t lost);
  /// Sends an event. `kind`: for example "tool", "fault", "end".
  void event(Nanos t, const std::string& kind, const std::string& text);
  /// Accepts readers, answers them, and sends waiting data. Call every few milliseconds.
  void turn();

  struct Counts {
    std::uint64_t readers = 0;  // number of connected readers
    std::uint64_t sent = 0;     // messages passed to the operating system
    std::uint64_t skipped = 0;  // messages not sent to slow readers
    std::uint64_t cut_off = 0;  // readers that were disconnected because they did not read
  };
  Counts counts() const;
  /// Port of the first WebSocket address; for "ws:0", the one that the system chose. 0: there is none.
  int port() const;

  static constexpr Nanos kPatience = 5 * kNanosPerSecond;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
