// Plays one recorded session, or two side by side: in a window with controls for position, speed, loop and viewpoint,
// or as a film. Render thread only.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/pose.h"
#include "engine/session/opened_session.h"
#include "engine/session/strings.h"

namespace typodont {

class Progress;

struct PlaybackOptions {
  std::filesystem::path beside;  // a second session, shown to the right of the first; empty: there is only one session
  std::string rig;  // file or name of a rig; empty: the scene's rig file, otherwise "window" or, for a film, "closeup"
  std::optional<dvec3> eye_W;   // m, frame W, midpoint between the viewer's eyes; empty: the rig file's value
  std::optional<double> ipd;    // m, interpupillary distance; empty: the rig file's value
  double magnify = 0;           // magnification of the picture; 0: the rig file's value
  double from = -1, to = 1e18;  // s, only the part between these times is played
  double speed = 1;             // multiple of the recorded speed; negative: backwards
  /// In a film: number of times that the range is played. In a window: 0 plays the range once, any other value repeats
  /// it without end.
  int loops = 1;
  double fps = 30;
  std::string view = "look";   // name of the view: look (normal), section, xray, difference or temperature
  std::filesystem::path film;  // .mp4 file that is written; empty: the session is shown in a window
  int monitor = -1;
  session::Language language = session::Language::kEnglish;  // language of the text over the picture
};

struct PlaybackResult {
  std::uint64_t frames = 0;
  double seconds = 0;   // s, duration of the film
  std::string message;  // lists the data that the film does not show; empty if it shows everything
};

/// Plays the sessions until the user closes the window. Keys: space, arrows, L, [ and ], R, V, Home, End, Esc. Throws
/// Error or RunFailure.
void show_session(const session::OpenedSession& session, const PlaybackOptions& options);
/// Writes a film. It has sound only if it plays forward, once, at normal speed. Throws Error or RunFailure.
PlaybackResult film_session(const session::OpenedSession& session, const PlaybackOptions& options, Progress& progress);

}  // namespace typodont
