// Replays a session from its recorded hand motion. The result is bit-identical, because the servo begins to use each
// new copy of the tissue at the recorded tick. A session of another force law is run with the current law.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine/app/scene.h"
#include "engine/contract/contact.h"
#include "engine/session/session_file.h"

namespace typodont {

/// Compares a session with a new run of its recorded hand motion, with another scene or another force law.
struct RerunResult {
  std::uint64_t ticks = 0, cuts = 0;
  double seconds = 0;
  /// Difference between the new and the recorded force over all ticks: root mean square, and largest, N.
  double force_off_rms = 0, force_off_max = 0;
  double force_max = 0, force_max_before = 0;  // N, largest force in the new run and the recording
  /// Difference between the new and the recorded position of the drawn tool: root mean square, and largest, m.
  double tool_off_rms = 0, tool_off_max = 0;
  double removed = 0, removed_before = 0;  // m³, removed volume in the new run and the recording
};

struct ReplayResult {
  // True if the replay equals the recording from the first to the last tick, in all data that the score depends on
  // (listed in stream_check.h).
  bool identical = false;
  bool truncated = false;  // true: the recording was cut off, so it is compared only up to its end
  double seconds = 0;
  std::uint64_t ticks = 0;
  std::uint64_t ticks_with_faults = 0;
  std::uint64_t first_difference = 0;  // index of the first tick that differs; used only if `identical` is false
  std::string field_hash, force_hash;
  std::string what_differs;  // describes the first difference; empty: none
  // Set for a session with another force law, whose hand motion was run again with the current law. Then
  // `first_difference`, `field_hash` and `force_hash` are not set.
  std::optional<RerunResult> with_todays_law;
};

/// True if the session used a force law other than the current one.
bool has_other_law(const session::SessionReader& session);

/// Replays a session and compares it with its recording. A session with another force law is run again with the current
/// law; `what_differs` then states the difference. Throws Error if the session's tissue is missing or has changed.
ReplayResult replay_session(const session::SessionReader& session, const std::function<void(double)>& progress = {});

/// The session's scene with changes. The keys of the JSON object `overrides` replace keys of the scene; a null value
/// removes a key. Throws Error.
Scene scene_with(const session::SessionReader& session, const std::string& overrides, const std::string& where);
/// Runs the servo of `scene` with the recorded motion of the hand, tick by tick, and repeats undos and redos. `out`:
/// file for the new session (.h5); empty: it is not stored.
RerunResult rerun_session(const session::SessionReader& session, const Scene& scene, const std::filesystem::path& out,
                          const std::function<void(double)>& progress = {});

/// Loads the scene of a session. `from`: place of the scene that continues this session. Throws Error if a file is
/// missing or has changed, or if a chain of sessions that continue each other is too long.
/// The session file is not trusted. It may refer only to files in its own folder, in the assets, or in a folder of
/// $TYPODONT_FILES; a session in the user's folder may refer to all files there. The listed files are found by their
/// SHA-256, also in the user's folder and in the current folder, and private copies are read.
Scene scene_of(const session::SessionReader& session, const ScenePlace& from = {});

}  // namespace typodont
