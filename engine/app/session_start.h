// Starts sessions that do not run in real time, for `typodont servo` and for programs that use the library.
#pragma once

#include <memory>
#include <string>

#include "engine/app/scene.h"
#include "engine/app/stepped.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Opens a hand whose motion is equal in every run: HAND.csv or HAND.json (also after "script:"), or replay:SESSION.h5.
/// The hand is an input device that does not wait for the real time of its samples. Throws Error.
std::unique_ptr<haptics::HapticDevice> open_unpaced_hand(const Scene& scene, const std::string& address, double rate);

/// Loads the scene's tissue and makes the session. Throws Error.
SteppedSession start_session(const Scene& scene, const haptics::DeviceInfo& hand);

}  // namespace typodont
