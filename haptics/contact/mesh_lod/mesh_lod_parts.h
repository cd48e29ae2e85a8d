// Parameters of "mesh_lod", and the snapshot that its carver thread passes to its servo thread.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/clock.h"
#include "haptics/contact/mesh_lod/head_points.h"
#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/contact/snapshot.h"

namespace typodont::haptics::mesh_lod {

struct Parameters {
  LevelOptions levels;
  // m/s, increasing speeds of the hand. Above the first speed, the second-finest level of detail is used, and so on.
  std::vector<double> switch_speed{30e-3, 120e-3};
  double hysteresis = 0.1;  // width of the hysteresis divided by the switching speed
  // true: when the level of detail changes, the contact point is mapped to the new mesh; false: it is computed again
  // from the hand's position
  bool maps = true;
  double ramp = 5;          // N/s, largest rate of the force after a change of level of detail; 0: the force may jump
  double wall_limit = 0.5;  // N, force above which a wall between tissues lets the tool through
};

/// Before the first cut, contains the constant levels of detail; afterwards, the faces around the tool.
struct MeshSnapshot : Snapshot {
  std::shared_ptr<const Levels> levels;
  bool cut = false;                 // true: `local` is valid instead of `levels`
  std::vector<TriangleGrid> local;  // faces in the box lo..hi; one grid per level
  dvec3 lo{0}, hi{0};               // m, box around the faces in `local`
  // m³, volume removed by the cuts in the snapshot, without undone cuts
  PerTissue removed{};
  // Contact points around the tool of the last cut, if contact is computed for its whole head. Null until the
  // first such list is made.
  std::unique_ptr<HeadPoints> points;
  std::uint32_t points_of = kNoTool;  // index of the tool of `points`; kNoTool: not valid
  static constexpr std::uint32_t kNoTool = ~0U;
};

/// Parameters of snapshots for a tool set that can cut.
struct LocalParameters {
  static constexpr double travel = 2e-3;  // m, distance that a tool that can cut may move until the next snapshot
  /// Distance that the tools may move until the next snapshot, m.
  static double travel_for(std::span<const Tool> tools) {
    const bool cuts = std::ranges::any_of(tools, [](const Tool& tool) { return tool.cuts; });
    return cuts ? travel : std::numeric_limits<double>::infinity();
  }
  // m; the snapshot contains faces up to this far beyond the tool and its possible motion `travel`
  static constexpr double margin = 0.5e-3;
  // distance for which contact points listed by the carver stay valid, divided by the head's radius
  static constexpr double listed = 0.45;
  // ns, smallest time between two snapshots (30 Hz, paper S3)
  static constexpr Nanos interval = 33'000'000;
};

}  // namespace typodont::haptics::mesh_lod
