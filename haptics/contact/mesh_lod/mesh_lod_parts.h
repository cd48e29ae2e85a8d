// Of both threads: parameters and snapshot.
#pragma once

#include <memory>
#include <vector>

#include "engine/base/clock.h"
#include "haptics/contact/mesh_lod/head_points.h"
#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/contact/snapshot.h"

namespace typodont::haptics::mesh_lod {

struct Parameters {
  LevelOptions levels;
  // m/s of the hand, increasing: above the first the second-finest level, and so on.
  std::vector<double> switch_speed{30e-3, 120e-3};
  double hysteresis = 0.1;  // of each speed, as a ratio
  // contact is mapped at a change of level; otherwise anew from the hand
  bool maps = true;
  double ramp = 5;          // N/s after a change of level; 0: one step
  double wall_limit = 0.5;  // N, at which a wall yields
};

/// Constant levels before the first cut, then the faces around the tool.
struct MeshSnapshot : Snapshot {
  std::shared_ptr<const Levels> levels;
  bool cut = false;                 // `local` is used, not `levels`
  std::vector<TriangleGrid> local;  // that overlap lo..hi; a grid per level, finest first
  dvec3 lo{0}, hi{0};               // m, around `local`
  // m³ by its cuts, without undone ones
  PerTissue removed{};
  // Around the last cut's tool, if contact is the whole head's; null before its first cut.
  std::unique_ptr<HeadPoints> points;
  std::uint32_t points_of = kNoTool;  // of `points`; kNoTool: not valid
  static constexpr std::uint32_t kNoTool = ~0U;
};

/// Of snapshots with a cutting tool.
struct LocalParameters {
  static constexpr double travel = 2e-3;  // m until the next
  // m beyond the tool and `travel`
  static constexpr double margin = 0.5e-3;
  // radii over which the carver's points hold
  static constexpr double listed = 0.45;
  // ns (30 Hz, S3)
  static constexpr Nanos interval = 33'000'000;
};

}  // namespace typodont::haptics::mesh_lod
