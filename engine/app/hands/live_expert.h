// The expert hand in a live session ("--hand expert:" of `typodont run`). It works in a closed loop, as in `typodont
// servo`: it reads its tool's pose in every tick, and after each finished plan it makes the next plan from the present
// tissue.
#pragma once

#include <memory>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Makes an expert hand. This takes seconds, because the first plan is made here, for the tissue `start` at the
/// session's start. Later plans are made by a separate thread, from copies of the tissue; during this time, the hand
/// waits above the tooth with the pedal released. The hand does not move during an emergency stop. If a plan is empty,
/// read() ends the session. `paced`: true if read() waits until the real time of each sample; false if it waits only
/// for plans. Throws Error if the task has no ideal result, or if no tool of the scene can begin the task.
std::unique_ptr<haptics::HapticDevice> make_live_expert(const Scene& scene, const haptics::TissueVolume& start,
                                                        Wiring& wiring, double rate, bool paced);

}  // namespace typodont
