// The hand of a recorded session as a hand again: --hand replay:SESSION.h5.
#pragma once

#include <filesystem>
#include <memory>

#include "haptics/haptic_device.h"

namespace typodont {

/// Pose and pedal of every recorded tick, interpolated to `rate`; it feels nothing. Throws Error when the file is no
/// session or holds no tick.
std::unique_ptr<haptics::HapticDevice> open_replay_hand(const std::filesystem::path& session_file, double rate,
                                                        bool paced);

/// Adds "replay:" to the addresses that haptics::open_hand takes. Set-up time, once.
void add_replay_driver();

}  // namespace typodont
