// A session run again from its hand, bit for bit, with the patches taken up when they were taken up then.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "engine/app/scene.h"
#include "engine/contract/contact.h"
#include "engine/session/session_file.h"
#include "haptics/tissue_volume.h"

namespace typodont {

struct ReplayResult {
  bool identical = false;  // every force and, where it was recorded, the tissue at the end
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

/// The scene a session was made with. Throws Error where its tissue is not there or has changed.
Scene scene_of(const session::SessionReader& session);

/// The tissue a session left, from the tissue its scene begins with and its cuts.
haptics::TissueVolume tissue_at_end(const session::SessionReader& session, const Scene& scene, haptics::TissueVolume start);

}  // namespace typodont
