// A live session's state for other programs, by OSC, and as JSON over WebSocket (docs/doors/stream.md).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/app/sound_link.h"
#include "engine/base/clock.h"
#include "engine/contract/contact.h"

namespace typodont {

/// Sent once to every reader.
struct StreamedSession {
  std::string scene;               // name of the scene
  std::vector<std::string> tools;  // ServoTick::tool is an index
  double servo_rate = 1000;        // Hz, rate of the servo
  SoundVoice voice;                // for its sound on another computer
};

/// One thread calls all, not the servo's. Nothing blocks, so slow readers lose messages; after kPatience without
/// reading or completing a request they are disconnected.
class StateStream {
 public:
  /// "osc:PORT", "osc:HOST:PORT": sent to; "ws:PORT", "ws:HOST:PORT": readers connect. Default host 127.0.0.1. Throws
  /// Error if invalid or in use.
  StateStream(const std::vector<std::string>& addresses, StreamedSession session);
  ~StateStream();
  StateStream(const StateStream&) = delete;
  StateStream& operator=(const StateStream&) = delete;

  /// `zero`: ns, monotonic clock, to which later times are relative.
  void begin(Nanos zero);
  /// `lost`: ticks that the stream did not receive.
  void state(const ServoTick& tick, std::uint64_t lost);
  /// `kind`: for example "tool", "fault", "end".
  void event(Nanos t, const std::string& kind, const std::string& text);
  /// Accepts and answers readers, sends waiting data. Every few milliseconds.
  void turn();

  struct Counts {
    std::uint64_t readers = 0;  // connected now
    std::uint64_t sent = 0;     // given to the operating system
    std::uint64_t skipped = 0;  // not sent to slow readers
    std::uint64_t cut_off = 0;  // disconnected, not reading
  };
  Counts counts() const;
  /// Of the first WebSocket address, as the system chose it for "ws:0"; 0: none.
  int port() const;

  static constexpr Nanos kPatience = 5 * kNanosPerSecond;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
