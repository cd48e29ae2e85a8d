// The expert hand in a live session ("--hand expert:" of `typodont run`). As in `typodont servo` it works in a closed
// loop: it reads its tool's pose in every tick, and after each finished plan it plans again from the tissue as it is.
#pragma once

#include <memory>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Makes the first plan before it returns, from `start`, the tissue at the session's start; this takes seconds. Later
/// plans are made on a thread of the hand's own, from copies of the tissue that the carver makes. Meanwhile the hand
/// waits above the tooth with the pedal up. It stands still while the session is held. read() ends the session when the
/// plan is empty. `paced`: read() waits for each sample's time on the clock; otherwise only for plans. Throws Error
/// when the task has no ideal, or when no tool of the scene can begin it.
std::unique_ptr<haptics::HapticDevice> make_live_expert(const Scene& scene, const haptics::TissueVolume& start,
                                                        Wiring& wiring, double rate, bool paced);

}  // namespace typodont
