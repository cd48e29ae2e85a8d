// Calibrates the working sound of a voice to levels measured on a real drill. Not for real time.
#pragma once

#include "audio/sound_models.h"

namespace typodont::audio {

/// Sets models.working_gain and models.brightness so that the voice has the measured levels at the measured contact:
/// the changes of the whole level and of the level above kBrightFrom, from idling at free speed to work. Returns false
/// if no gains give these levels.
bool calibrate(SoundModels& models, const WorkLevel& measured);

}  // namespace typodont::audio
