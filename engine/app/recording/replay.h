// A session run again from its hand, bit for bit, with the patches taken up when they were taken up then.
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
  bool identical = false;  // everything that a score is made of (stream_check.h), from the first tick to the last
  bool truncated = false;  // the recording was cut off; checked as far as it goes
  double seconds = 0;
  std::uint64_t ticks = 0;
  std::uint64_t ticks_with_faults = 0;
  std::uint64_t first_difference = 0;  // tick; meaningful when not identical
  std::string field_hash, force_hash;
  std::string what_differs;  // in words; empty when identical
};

/// Throws Error when the file is no session, or the tissue it was made with is not there or has changed.
ReplayResult replay_session(const std::filesystem::path& session_file,
                            const std::function<void(double)>& progress = {});

/// The same hand in another scene: another coupling, other friction, another filter, another tissue.
struct RerunResult {
  std::uint64_t ticks = 0, cuts = 0;
  double seconds = 0;
  double force_off_rms = 0, force_off_max = 0;  // N, of the difference of the two forces over all ticks
  double force_max = 0, force_max_before = 0;   // N
  double tool_off_rms = 0, tool_off_max = 0;    // m, of where the tool is drawn
  double removed = 0, removed_before = 0;       // m³
};
/// The session's scene with these keys of `overrides` (a JSON object) in place of its own; null takes a key away.
/// Throws Error.
Scene scene_with(const session::SessionReader& session, const std::string& overrides, const std::string& where);
/// Feeds the recorded hand, tick by tick, to the scene's servo. `out`: the new session (.h5); empty: not kept.
RerunResult rerun_session(const session::SessionReader& session, const Scene& scene, const std::filesystem::path& out,
                          const std::function<void(double)>& progress = {});

/// The scene a session was made with. It comes from a file that may be a stranger's, so that the files it names must
/// lie in the session's own folder, in the assets or in a folder of $TYPODONT_FILES; of a session in the user's folder,
/// in that. `recordings`: out of which this session was named. Throws Error where its tissue is not there or has
/// changed, and where too many recordings name each other.
Scene scene_of(const session::SessionReader& session, int recordings = 0);

/// The carver of a recorded session as it stood at t: `start` with all cuts and edits made until then.
std::unique_ptr<haptics::Carver> carver_at(const session::SessionReader& session, const Scene& scene,
                                           haptics::TissueVolume start, Nanos t);
/// The tissue as it was at a moment of a session, from the tissue its scene begins with and its cuts; and as it was
/// left.
haptics::TissueVolume tissue_at(const session::SessionReader& session, const Scene& scene, haptics::TissueVolume start,
                                Nanos t);
haptics::TissueVolume tissue_at_end(const session::SessionReader& session, const Scene& scene,
                                    haptics::TissueVolume start);

/// The last tick not after t, and its place among all; the first where there is none before. The session has ticks.
std::uint64_t place_of_tick_at(const session::SessionReader& session, Nanos t);
ServoTick tick_at(const session::SessionReader& session, Nanos t);

}  // namespace typodont
