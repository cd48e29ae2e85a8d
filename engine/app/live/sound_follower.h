// The sound of a session on another computer, from its stream (docs/doors/stream.md).
#pragma once

#include <cstdint>
#include <string>

namespace typodont {

struct FollowOptions {
  std::string address;  // "ws:[HOST:]PORT" of the session
  std::string audio;    // as of SoundLink
  double wait = 0.02;   // s that a sound device waits for late states
  double seconds = 0;   // 0: to the session's end
};

struct FollowedSound {
  std::string scene;
  std::uint64_t states = 0, lost = 0;  // received; ticks that the stream lost
  double seconds = 0;                  // of the session
  double delay = 0;                    // s, from a state's arrival to its sound; NaN for files
  double network = 0;                  // s, from a tick to the fastest arrival, if both computers' clocks agree
};

/// Until the session, its connection or the time ends. Throws Error, RunFailure.
FollowedSound follow_sound(const FollowOptions& options);

}  // namespace typodont
