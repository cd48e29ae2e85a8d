// Makes a device of the hand in a recorded session: --hand replay:SESSION.h5.
#pragma once

#include <filesystem>
#include <memory>

#include "haptics/haptic_device.h"

namespace typodont {

/// Returns pose and pedal of the recorded ticks, interpolated to `rate` (Hz); ignores forces. Throws Error if the file
/// is not a session or has no ticks.
std::unique_ptr<haptics::HapticDevice> open_replay_hand(const std::filesystem::path& session_file, double rate,
                                                        bool paced);

/// Adds "replay:" to the addresses of haptics::open_hand. Set-up time, once.
void add_replay_driver();

}  // namespace typodont
