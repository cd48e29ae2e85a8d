// Replays a session from its recorded hand, bit for bit. Each patch is adopted at the same tick as in the session.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "engine/app/scene.h"
#include "engine/contract/contact.h"
#include "engine/session/session_file.h"
#include "haptics/tissue_volume.h"

namespace typodont {

namespace haptics {
class Carver;
}

struct ReplayResult {
  // true: all data that the score depends on is equal (stream_check.h), from the first tick to the last
  bool identical = false;
  bool truncated = false;  // the recording was cut off and is compared up to its end
  double seconds = 0;
  std::uint64_t ticks = 0;
  std::uint64_t ticks_with_faults = 0;
  std::uint64_t first_difference = 0;  // index of the first tick that differs; valid if `identical` is false
  std::string field_hash, force_hash;
  std::string what_differs;  // description of the first difference; empty if identical
};

/// Replays a session and compares it with its recording. Throws Error if the file is not a session, or if its tissue is
/// missing or has changed.
ReplayResult replay_session(const std::filesystem::path& session_file,
                            const std::function<void(double)>& progress = {});

/// Result of running the recorded hand in a changed scene, for example with another coupling, friction, filter or
/// tissue.
struct RerunResult {
  std::uint64_t ticks = 0, cuts = 0;
  double seconds = 0;
  double force_off_rms = 0, force_off_max = 0;  // N, difference of the two forces over all ticks
  double force_max = 0, force_max_before = 0;   // N, largest force in the new run and in the recording
  double tool_off_rms = 0, tool_off_max = 0;    // m, difference of the drawn tool positions
  double removed = 0, removed_before = 0;       // m³, removed volume in the new run and in the recording
};
/// The session's scene with changes: the keys of `overrides` (a JSON object) replace the scene's own keys; null
/// removes a key. Throws Error.
Scene scene_with(const session::SessionReader& session, const std::string& overrides, const std::string& where);
/// Feeds the recorded hand to the scene's servo, tick by tick. `out`: file for the new session (.h5); empty: the new
/// session is not stored.
RerunResult rerun_session(const session::SessionReader& session, const Scene& scene, const std::filesystem::path& out,
                          const std::function<void(double)>& progress = {});

/// The scene of a session. The session file may be untrusted. So the files that it names must be in the session's own
/// folder, in the assets, or in a folder of $TYPODONT_FILES; for a session in the user's folder they may also be in
/// that folder. `recordings`: length of the chain of recordings that leads to this session. Throws Error if the tissue
/// is missing or has changed, or if the chain is too long.
Scene scene_of(const session::SessionReader& session, int recordings = 0);

/// The carver of a recorded session at time t: `start` after all cuts and edits up to t.
std::unique_ptr<haptics::Carver> carver_at(const session::SessionReader& session, const Scene& scene,
                                           haptics::TissueVolume start, Nanos t);
/// The tissue at time t of a session, and at its end, computed from the initial tissue `start` and the recorded cuts.
haptics::TissueVolume tissue_at(const session::SessionReader& session, const Scene& scene, haptics::TissueVolume start,
                                Nanos t);
haptics::TissueVolume tissue_at_end(const session::SessionReader& session, const Scene& scene,
                                    haptics::TissueVolume start);

/// Index of the last tick that is not after t; if all ticks are after t, index of the first tick. The session must
/// have ticks.
std::uint64_t place_of_tick_at(const session::SessionReader& session, Nanos t);
ServoTick tick_at(const session::SessionReader& session, Nanos t);

}  // namespace typodont
