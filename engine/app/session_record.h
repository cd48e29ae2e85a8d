// What the program writes into a session beside the ticks.
#pragma once

#include "engine/app/scene.h"
#include "engine/session/session_data.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Scene and rig in full, hashes of the files they were made from, the hand, the volumes at the start.
session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::HapticDevice& hand, const haptics::TissueVolume& tissue,
                                      double rate);

/// Samples of the second hand: its pose as held and its pedal, on the session's clock.
session::StreamSpec left_hand_stream();

/// Volumes, pulp distance and field hash at the end.
session::SessionResult session_result(const haptics::TissueVolume& tissue);

}  // namespace typodont
