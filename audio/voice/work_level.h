// Fits a voice to measured levels. Not for real time.
#pragma once

#include "audio/sound_models.h"

namespace typodont::audio {

/// Sets working_gain and brightness so that whole level and level above kBrightFrom rise from idle as measured. False:
/// impossible.
bool calibrate(SoundModels& models, const WorkLevel& measured);

}  // namespace typodont::audio
