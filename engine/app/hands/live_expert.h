// The expert's hand in a live session ("--hand expert:" of `typodont run`). It works in a closed loop like the one of
// `typodont servo`: it watches its tool tick by tick, and after each plan it looks at the tissue and plans the rest.
#pragma once

#include <memory>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Plans the first strokes now, from `start`, the tissue as the session begins: takes seconds. Later plans are made on
/// a thread of its own from copies of the tissue that the carver makes; meanwhile the hand waits above the tooth, pedal
/// up. While the session is held it stands still. Its read() ends the session when nothing is left to do. `paced`:
/// waits for each sample's time on the clock; otherwise it waits for its plans only. Throws Error where the task names
/// no ideal, or no tool serves it.
std::unique_ptr<haptics::HapticDevice> make_live_expert(const Scene& scene, const haptics::TissueVolume& start,
                                                        Wiring& wiring, double rate, bool paced);

}  // namespace typodont
