// The expert hand in a live session ("--hand expert:" of `typodont run`). As in `typodont servo`, it works in a
// closed loop: it reads its tool's pose in every tick, and after each finished plan it makes the next plan from the
// present tissue.
#pragma once

#include <memory>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Makes the first plan from `start`, the tissue at the session's start, before it returns; this takes seconds. A
/// thread of its own makes the later plans, from copies of the tissue that the carver makes. Meanwhile the hand waits
/// above the tooth with the pedal released. The hand does not move during an emergency stop. read() ends the session
/// when the plan is empty. `paced`: read() waits for each sample's time on the clock; otherwise it waits only for
/// plans. Throws Error if the task has no ideal, or if no tool of the scene can begin it.
std::unique_ptr<haptics::HapticDevice> make_live_expert(const Scene& scene, const haptics::TissueVolume& start,
                                                        Wiring& wiring, double rate, bool paced);

}  // namespace typodont
