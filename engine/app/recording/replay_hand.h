// Input device that repeats the hand motion of a recorded session: --hand replay:SESSION.h5.
#pragma once

#include <memory>

#include "engine/session/session_file.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Makes a device that reports the pose and pedal of the recorded ticks, interpolated to `rate` (Hz). It ignores
/// forces. `paced`: it delivers samples in real time. Throws Error if the session contains no ticks.
std::unique_ptr<haptics::HapticDevice> open_replay_hand(const session::SessionReader& session, double rate, bool paced);

/// Makes haptics::open_hand accept the addresses "replay:…". Call once, at set-up.
void add_replay_driver();

}  // namespace typodont
