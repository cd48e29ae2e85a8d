// The hand of the demo: a student who looks before drilling. It draws the tool over the lesion with the drill at rest,
// in both directions, removes the caries as the expert does, and draws the tool away.
#pragma once

#include "engine/app/scene.h"
#include "haptics/scripted_hand.h"
#include "haptics/tissue_volume.h"

namespace typodont {

struct StudentPlan {
  haptics::HandPath path;
  double explore_end = 0;  // s: before it the drill stands still
  double drill_end = 0;    // s: after it the tool is drawn away
};

/// `tissue` as the scene begins. Works out the expert's session at `rate` Hz, which takes a while and shows its
/// progress. Throws Error when the tissue holds no caries or the scene's task names no ideal.
StudentPlan plan_caries_removal(const Scene& scene, const haptics::TissueVolume& tissue, double rate);

}  // namespace typodont
