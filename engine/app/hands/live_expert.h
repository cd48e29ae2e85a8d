// "--hand expert:" of `typodont run`: follows the expert's strokes in a closed loop, as in `typodont servo`.
#pragma once

#include <memory>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// The expert of a task that needs no plan of strokes: an implant exercise, or the probing of pockets. Null for other
/// tasks.
std::unique_ptr<haptics::HapticDevice> make_unplanned_expert(const Scene& scene, double rate);

/// Makes the expert, and the first plan for the tissue `start`, which takes seconds. A thread makes later plans from
/// copies of the tissue, while the hand waits above the tooth. The hand rests during an emergency stop. An empty plan
/// ends the session.
/// `paced`: read() waits for real time; otherwise it waits only for plans.
/// Throws Error if the task has no ideal shape, or if no tool brings the tissue nearer to this shape.
std::unique_ptr<haptics::HapticDevice> make_live_expert(const Scene& scene, const haptics::TissueVolume& start,
                                                        Wiring& wiring, double rate, bool paced);

}  // namespace typodont
