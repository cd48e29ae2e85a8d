// What both halves of "mesh_lod" know: the parameters of the scene and the snapshot.
#pragma once

#include <memory>
#include <vector>

#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/snapshot.h"

namespace typodont::haptics::mesh_lod {

struct Parameters {
  LevelOptions levels;
  std::vector<double> switch_speed{30e-3, 120e-3};  // m/s of the hand, from each level to the next coarser one
  double hysteresis = 0.1;                          // a level is left at so much beyond its speed, either way
  bool maps = true;         // the contact point is mapped onto the next level; else it is found anew from the hand
  double ramp = 5;          // N/s at which the difference between two levels is given to the hand; 0: at once
  double wall_limit = 0.5;  // N at which a wall between tissues gives way
};

/// The levels, which never change. All of the tissue, so one snapshot serves for good.
struct MeshSnapshot : Snapshot {
  std::shared_ptr<const Levels> levels;
};

}  // namespace typodont::haptics::mesh_lod
