// Magnifies the tissue's picture: moves the rig's screen and eyes.
#pragma once

#include "engine/display/display_rig.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Applies "magnify" of the rig file: enlarges about the rig's point or the middle of the tissue's top. Logs how that
/// affects the co-location of tool and hand. Not for headsets, which magnify themselves.
display::DisplayRig magnified_for(const display::DisplayRig& rig, const haptics::TissueVolume& tissue);

}  // namespace typodont
