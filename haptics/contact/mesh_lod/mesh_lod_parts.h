// Data types shared by the two parts of the contact model "mesh_lod" (servo thread and carver thread): the parameters
// of a scene and the snapshot.
#pragma once

#include <memory>
#include <vector>

#include "engine/base/clock.h"
#include "haptics/contact/mesh_lod/head_points.h"
#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/snapshot.h"

namespace typodont::haptics::mesh_lod {

struct Parameters {
  LevelOptions levels;
  // m/s, speeds of the hand at which the level of detail changes, in increasing order. Above the first speed the
  // second-finest level is used, above the second speed the third-finest, and so on.
  std::vector<double> switch_speed{30e-3, 120e-3};
  double hysteresis = 0.1;  // hysteresis around each limit of the hand's speed, as a ratio to that limit
  // true: at a change of level, the contact point is mapped to the new mesh; false: it is computed again from the
  // hand's position
  bool maps = true;
  double ramp = 5;  // N/s, rate of change of the force after a change of level; 0: the force changes in one step
  double wall_limit = 0.5;  // N, force at which a wall between two tissues yields
};

/// The tissue's surface for the servo. Before the first cut the servo uses the meshes of the levels of detail, which
/// never change. After the first cut it uses the present faces around the tool.
struct MeshSnapshot : Snapshot {
  std::shared_ptr<const Levels> levels;
  bool cut = false;                 // true if the tissue was cut; `local` is then used instead of `levels`
  std::vector<TriangleGrid> local;  // all faces that overlap the box from lo to hi; one grid per level, finest first
  dvec3 lo{0}, hi{0};               // m, corners of the box that contains the faces in `local`
  // m³, volume that all cuts in this snapshot have removed; cuts that were undone do not count
  PerTissue removed{};
  // Contact points around the tool of the last cut; only for a tool whose contact is computed for the whole head (a bur
  // that is not a ball). Null before the first cut by such a tool.
  std::unique_ptr<HeadPoints> points;
  std::uint32_t points_of = kNoTool;  // the tool around which `points` lie; kNoTool: `points` is not valid
  static constexpr std::uint32_t kNoTool = ~0U;
};

/// Sizes and update rate of the snapshots (copies of the mesh around the tool) in a session with a cutting tool.
struct LocalParameters {
  static constexpr double travel = 2e-3;  // m, distance that the tool may move before the next snapshot is due
  // m, width that a snapshot has beyond the tool's size and the motion `travel` that is allowed in it
  static constexpr double margin = 0.5e-3;
  // ratio to the head's radius; contact points from the carver thread are valid up to this displacement of the head
  static constexpr double listed = 0.45;
  // ns, time between two updates of the geometry (30 Hz, as in paper S3)
  static constexpr Nanos interval = 33'000'000;
};

}  // namespace typodont::haptics::mesh_lod
