// Adapts a drill's sound models to measured levels. Not for real time.
#pragma once

#include "audio/sound_models.h"

namespace typodont::audio {

/// Sets working_gain and brightness so that, from idling to cutting, the level of the whole sound and its level above
/// kBrightFrom rise as measured. Returns false if this is impossible.
bool calibrate(SoundModels& models, const WorkLevel& measured);

}  // namespace typodont::audio
