// Plays recorded sessions: in a window with seeking, speed, loop and viewpoint, or as a film. Plays one session, or two
// sessions side by side. Drawing thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/pose.h"
#include "engine/session/strings.h"

namespace typodont {

class Progress;

struct PlaybackOptions {
  std::filesystem::path session;
  std::filesystem::path beside;  // a second session, shown at the right; empty: none
  std::string rig;  // rig file, or the name of a rig in assets/rigs; empty: "window", or "closeup" for a film
  std::optional<dvec3> eye_W;   // m, midpoint between the eyes; empty: the rig's value
  std::optional<double> ipd;    // m, interpupillary distance; empty: the rig's value
  double magnify = 0;           // magnification; 0: the rig's value
  double from = -1, to = 1e18;  // s, range of the recording to play
  double speed = 1;             // factor on the recorded speed; negative: backwards
  int loops = 1;                // repetitions of a film; in a window 0 plays once, any other value repeats forever
  double fps = 30;
  std::string view = "look";   // name of the view: look (normal), section, xray, difference
  std::filesystem::path film;  // .mp4 file; empty: a window
  int monitor = -1;
  session::Language language = session::Language::kEnglish;  // language of the text over the picture
};

struct PlaybackResult {
  std::uint64_t frames = 0;
  double seconds = 0;   // s, duration of the film
  std::string message;  // names data that is missing in the film; empty if it is complete
};

/// Plays the sessions until the window is closed. Keys: space, arrows, L, [ and ], R, V, Home, End, Esc. Throws
/// Error, RunFailure.
void show_session(const PlaybackOptions& options);
/// Makes a film. The film has sound if it plays forward, at normal speed, once. Throws Error, RunFailure.
PlaybackResult film_session(const PlaybackOptions& options, Progress& progress);

}  // namespace typodont
