// Magnifies the pictures of the work.
#pragma once

#include "engine/display/display_rig.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Applies the rig's "magnify": moves screen and eyes towards the rig's point or, without a point, towards the middle
/// of the tissue's upper side. Logs the effect on co-location. Not for headsets, which magnify by themselves.
display::DisplayRig magnified_for(const display::DisplayRig& rig, const haptics::TissueVolume& tissue);

}  // namespace typodont
