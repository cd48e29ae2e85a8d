// What both halves of "mesh_lod" know: the parameters of the scene and the snapshot.
#pragma once

#include <memory>
#include <vector>

#include "engine/base/clock.h"
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

/// The levels, which never change, and once something was cut the faces around the tool as they are now.
struct MeshSnapshot : Snapshot {
  std::shared_ptr<const Levels> levels;
  bool cut = false;                 // `local` counts, and `levels` do not
  std::vector<TriangleGrid> local;  // all faces that reach into the box lo ..
                                    // hi: as many levels, finest first
  dvec3 lo{0}, hi{0};               // m
  PerTissue removed{};              // m³ by the cuts that it contains, less what undo brought back
};

/// Of sessions with a tool that cuts.
struct LocalParameters {
  static constexpr double travel = 2e-3;         // m that the tool may move before another snapshot is due
  static constexpr double margin = 0.5e-3;       // m beyond the travel and the tool that a snapshot holds
  static constexpr Nanos interval = 33'000'000;  // ns, of the geometry: 30 Hz, as in the paper
};

}  // namespace typodont::haptics::mesh_lod
