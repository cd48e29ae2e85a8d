// Data types that both parts of the contact model "mesh_lod" use (servo thread and carver thread): the scene's
// parameters and the snapshot.
#pragma once

#include <memory>
#include <vector>

#include "engine/base/clock.h"
#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/snapshot.h"

namespace typodont::haptics::mesh_lod {

struct Parameters {
  LevelOptions levels;
  // m/s, thresholds of the hand's speed, from each level to the next coarser level
  std::vector<double> switch_speed{30e-3, 120e-3};
  double hysteresis = 0.1;  // relative hysteresis around each threshold
  bool maps = true;  // true: the contact point is mapped to the next level; false: it is computed again from the hand
  double ramp = 5;   // N/s, rate at which the difference between two levels is applied to the force; 0: at once
  double wall_limit = 0.5;  // N, force at which a wall between tissues yields
};

/// The tissue's surface for the servo: the levels, which never change, and, after the first cut, the present faces
/// around the tool.
struct MeshSnapshot : Snapshot {
  std::shared_ptr<const Levels> levels;
  bool cut = false;                 // the tissue was cut, so `local` is used instead of `levels`
  std::vector<TriangleGrid> local;  // all faces that reach into the box lo .. hi; one grid per level, finest first
  dvec3 lo{0}, hi{0};               // m
  PerTissue removed{};              // m³, volume removed by the cuts that this snapshot contains, without undone cuts
};

/// Parameters for sessions with a cutting tool.
struct LocalParameters {
  static constexpr double travel = 2e-3;         // m, distance that the tool may move before the next snapshot is due
  static constexpr double margin = 0.5e-3;       // m, margin of a snapshot beyond the travel and the tool
  static constexpr Nanos interval = 33'000'000;  // ns, time between updates of the geometry: 30 Hz, as in the paper
};

}  // namespace typodont::haptics::mesh_lod
