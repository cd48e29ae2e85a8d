// A hand that knows its task: it explores the surface with the drill at rest, then removes all caries from above, layer
// by layer. For demonstrations and for tests that need a plausible session on any scene with a lesion.
#pragma once

#include "haptics/scripted_hand.h"
#include "haptics/tissue_volume.h"

namespace typodont {

struct StudentPlan {
  haptics::HandPath path;
  haptics::HandModel hand;
  double explore_end = 0;  // s: before it the drill stands still
  double drill_end = 0;    // s: after it the tool is drawn away
};

/// Plans from the labels alone. Throws Error when the tissue holds no caries.
StudentPlan plan_caries_removal(const haptics::TissueVolume& tissue, const haptics::Tool& tool);

}  // namespace typodont
