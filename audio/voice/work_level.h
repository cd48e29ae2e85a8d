// Calibrates the working sound of a voice to levels measured on a real drill. Not for real time.
#pragma once

#include "audio/sound_models.h"

namespace typodont::audio {

/// Sets models.working_gain and models.brightness from a measurement. When the drill goes from idling at free speed to
/// the measured contact, two levels then change as measured: the level of the whole sound, and the level above
/// kBrightFrom. Returns false if no gains give these levels.
bool calibrate(SoundModels& models, const WorkLevel& measured);

}  // namespace typodont::audio
