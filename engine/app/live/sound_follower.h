// Plays the sound of a session that runs on another computer, from its stream (docs/doors/stream.md).
#pragma once

#include <cstdint>
#include <string>

namespace typodont {

struct FollowOptions {
  std::string address;  // address of the session's stream, "ws:[HOST:]PORT"
  std::string audio;    // address of the sound output, as for SoundLink
  double wait = 0.02;   // s, time that a sound device waits for session states that arrive late
  double seconds = 0;   // s, time after which playback ends; 0: at the session's end
};

struct FollowedSound {
  std::string scene;
  std::uint64_t states = 0, lost = 0;  // number of received states; number of ticks that are missing in the stream
  double seconds = 0;                  // s, duration of the received session
  double delay = 0;                    // s, time from a state's arrival to its sound; NaN for files
  double network = 0;                  // s, shortest time from a tick to its arrival, if both computers' clocks agree
};

/// Plays the sound until the session or the time ends. Throws Error, or RunFailure if the connection is lost.
FollowedSound follow_sound(const FollowOptions& options);

}  // namespace typodont
