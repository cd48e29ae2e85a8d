// A picture that shows the work larger than life.
#pragma once

#include "engine/display/display_rig.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// As the rig's "magnify" asks: the rig with its screen and eyes shrunk about the point that it names, else about the
/// middle of the tissue's upper side. Logs what becomes of co-location. Any rig but a headset's, which magnifies by
/// itself.
display::DisplayRig magnified_for(const display::DisplayRig& rig, const haptics::TissueVolume& tissue);

}  // namespace typodont
