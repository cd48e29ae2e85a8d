// Recorded sessions shown: in a window, where one can seek, slow down, loop and look at the same hand with other eyes;
// or as a film. One session, or two beside each other. Drawing thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/pose.h"

namespace typodont {

class Progress;

struct PlaybackOptions {
  std::filesystem::path session;
  std::filesystem::path beside;  // another one of the same work, at its right; empty: alone
  std::string rig;               // file, or the name of one in assets/rigs; empty: window, and closeup for a film
  std::optional<dvec3> eye_W;    // m, between the eyes; else the rig's
  std::optional<double> ipd;     // m
  double magnify = 0;            // instead of what the rig says; 0: as the rig says
  double from = -1, to = 1e18;   // s of the recording
  double speed = 1;              // negative: backwards
  int loops = 1;                 // of a film; in a window 0 plays once, anything else for ever
  double fps = 30;
  std::string view = "look";   // look, section, xray, difference
  std::filesystem::path film;  // .mp4; empty: a window
  int monitor = -1;
};

struct PlaybackResult {
  std::uint64_t frames = 0;
  double seconds = 0;   // of film
  std::string message;  // what is missing in the film; empty when all is well
};

/// Until the window is closed. Keys: space, arrows, L, [ and ], R, V, Home, End, Esc. Throws Error, RunFailure.
void show_session(const PlaybackOptions& options);
/// Sound where it plays at its own speed, forward, once. Throws Error, RunFailure.
PlaybackResult film_session(const PlaybackOptions& options, Progress& progress);

}  // namespace typodont
