// Warnings over the picture while the trainee works: near the pulp, near a neighbouring tooth, too much force, wrong
// axis. They follow the task's rules and fade as the trainee improves (docs/tasks.md#warnings).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/contract/contact.h"
#include "engine/session/session_data.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// In order of priority.
enum class Warning { kNone, kPulp, kNeighbour, kForce, kAxis };

/// An error that a warning should prevent. SI units, angles in rad.
struct WarningRule {
  Warning warning = Warning::kNone;
  std::string item;              // item of the score that the error lowers
  double limit = 0, margin = 0;  // the error begins at `limit`, the warning of level 1 by `margin` before it
};
/// The warnings that the scene's task gives. Empty: no task, switched off, or an implant exercise, which has its own
/// notes (session::ImplantNote).
std::vector<WarningRule> warning_rules(const Scene& scene);

/// Decides which warning is shown. Equal ticks give equal warnings. One thread only.
class WarningMeter {
 public:
  /// `start`: tissue at the session's start; used only in this call. Throws Error.
  WarningMeter(const Scene& scene, const haptics::TissueVolume& start, const session::WarningLevels& levels);
  /// Goes back to the start of the session.
  void restart();
  /// Adds each tick, for the largest force since the last evaluation.
  void add(const ServoTick& tick);
  /// Evaluates the newest tick. Call a few times per second of session time t, ns.
  void evaluate(const ServoTick& tick, Nanos t);
  /// The warning to show; each is shown for at least kShown.
  Warning current() const { return current_; }

  static constexpr Nanos kShown = 1 * kNanosPerSecond;

 private:
  struct Head {
    bool turns = false, ball = false;
    double reach = 0;  // m, distance from the head's centre to its farthest point
    haptics::HeadField field;
    std::vector<dvec3> surface_T;  // m, frame T, points on the head
  };
  /// A cube of the pulp: centres of its outermost voxels, m, frame W.
  struct PulpBlock {
    dvec3 middle{0};
    std::vector<dvec3> points;
  };
  void add_pulp(const DenseCopy& copy);
  bool applies(const WarningRule& rule, const ServoTick& tick, const Head& head) const;
  bool pulp_within(double distance, const Head& head, const Pose& X_WG) const;
  bool neighbour_within(double distance, const Head& head, const Pose& X_WG) const;

  std::vector<WarningRule> rules_;  // their margins are multiplied by the trainee's levels
  std::vector<Head> heads_;
  dvec3 axis_W_{0, 0, 1};
  std::vector<PulpBlock> pulp_;
  double half_voxel_ = 0;                    // m
  std::optional<SurroundingsShape> around_;  // empty: no rule about neighbouring teeth
  double max_force_ = 0;                     // N, since the last evaluation
  Warning current_ = Warning::kNone;
  Nanos until_ = 0;  // ns, shown at least until this time
};

}  // namespace typodont
