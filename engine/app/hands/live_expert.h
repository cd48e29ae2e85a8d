// "--hand expert:" of `typodont run`, in a closed loop as in `typodont servo`.
#pragma once

#include <memory>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Takes seconds: the first plan, for the tissue `start`, is made here. Later ones come from a thread that works on
/// copies, while the hand waits above the tooth. Still during an emergency stop. An empty plan ends the session.
/// `paced`: read() waits for real time, otherwise only for plans. Throws Error without an ideal result or a tool that
/// can begin.
std::unique_ptr<haptics::HapticDevice> make_live_expert(const Scene& scene, const haptics::TissueVolume& start,
                                                        Wiring& wiring, double rate, bool paced);

}  // namespace typodont
