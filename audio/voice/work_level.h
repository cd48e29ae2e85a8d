// Calibrates the working sound of a voice to levels measured on a real drill. Not for real time.
#pragma once

#include "audio/sound_models.h"

namespace typodont::audio {

/// Sets models.working_gain and models.brightness so that the change from idling at free speed to the measured contact
/// agrees with the measurement, both for the level of the whole sound and for the level above kBrightFrom. Returns
/// false if no gains give these levels.
bool calibrate(SoundModels& models, const WorkLevel& measured);

}  // namespace typodont::audio
