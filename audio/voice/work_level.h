// Calibrates the working sound of a voice to levels measured on a real drill. Not for real time.
#pragma once

#include "audio/sound_models.h"

namespace typodont::audio {

/// Sets models.working_gain and models.brightness so that two level differences between the drill at work and the
/// idling drill equal the measured ones: that of the whole sound, and that of the frequencies above kBrightFrom (4
/// kHz). `measured`: measurement on a real drill. Returns false if no values give these differences.
bool calibrate(SoundModels& models, const WorkLevel& measured);

}  // namespace typodont::audio
