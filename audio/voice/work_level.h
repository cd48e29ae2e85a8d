// Adapts a voice to measured levels. Not for real time.
#pragma once

#include "audio/sound_models.h"

namespace typodont::audio {

/// Sets working_gain and brightness so that the whole level and the level above kBrightFrom rise from idle as measured.
/// Returns false if this is impossible.
bool calibrate(SoundModels& models, const WorkLevel& measured);

}  // namespace typodont::audio
