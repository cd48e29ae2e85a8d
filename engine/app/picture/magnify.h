// Magnifies the picture of the tissue: moves screen and eyes of the display rig, so that the user sees the tissue
// larger.
#pragma once

#include "engine/display/display_rig.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Applies the key "magnify" of the rig file. Moves screen and eyes towards the point that the rig states, or towards
/// the middle of the tissue's upper side. Logs the effect on co-location (picture and hand at one place). A headset
/// magnifies in its own code, so it does not use this function.
display::DisplayRig magnified_for(const display::DisplayRig& rig, const haptics::TissueVolume& tissue);

}  // namespace typodont
