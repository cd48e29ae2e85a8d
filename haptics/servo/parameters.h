// Parameters of the steps of a servo tick, each with its unit and reason. The parameters of a contact method are in
// that method's folder.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// Motion of the hand from tick to tick (servo.cpp).
struct MotionParameters {
  // m/s; a motion faster than this counts as a jump of the input
  static constexpr double hand_speed_limit = 2.0;
  static constexpr double leap_time = 0.05;  // s, time in which the proxy may follow a jump of the input
  // m; if the proxy is farther than this from the hand after an interruption, it starts again at the
  // hand
  static constexpr double lost_distance = 0.02;
  // m; input is illegal if the hand is farther than this from the origin of the workbench frame W
  static constexpr double workspace = 100;
  // s; a tick that is longer than this counts as a jump of the clock, and a nominal tick is used instead
  static constexpr double longest_tick = 0.1;
  // s; if a new snapshot has been due for longer than this, the servo reports a fault
  static constexpr double stale_time = 0.02;
};

/// Energy that a bur earns and spends (cutting.cpp).
struct CuttingParameters {
  // s; while a bur presses on tissue, it stores the energy of its motor until the energy is enough to remove a voxel.
  // The stored energy grows up to the present power multiplied by this time. A tool that touches no tissue stores
  // nothing.
  static constexpr double budget_time = 0.5;
  // s; replaces budget_time if the bur is at a border to harder tissue, or if the hand draws an edge over the tissue
  static constexpr double held_time = 0.05;
  // m³; a bur that breaks into tissue may remove at most this volume before its motor has done the work for the
  // removal
  static constexpr double owed_volume = 8e-12;
  // number of voxels; owed_volume is at least the volume of this many voxels, because on a grid with voxels larger than
  // 0.1 mm, 8e-12 m³ would be less than eight voxels
  static constexpr double owed_voxels = 8;
};

/// Parameters of the contact's force and torque (coupling.cpp).
struct CouplingParameters {
  // s, time constant with which the stiffness and the torque that the hand feels are smoothed
  static constexpr double stiffness_time = 4e-3;
  // s, time constant of the low-pass filter for the damper's velocity, used when a tool cuts or fills
  static constexpr double cut_damping_time = 4e-3;
  static constexpr double tissue_slew = 4;  // N/s, largest force change due to a change of the tissue under the head
  static constexpr double damper_slew = 4;  // N/s, largest change of the damper's force when a tool cuts or fills
  static constexpr double teeth_slew = 4;   // N/s, largest change of the cutting edges' tangential force
  // N/s, largest change of the normal force by all causes together. A change of the depth uses this limit first; a new
  // stiffness of the tissue and the damper may use what remains of it in the tick.
  static constexpr double waiting_slew = 16;
  // N/s, largest change of the force by all causes together. All other changes use this limit first; the force of the
  // cutting edges may use what remains of it in the tick.
  static constexpr double total_slew = 18;
  // J; if the tissue under the head becomes stiffer, the coupling may always store up to this energy, even if the
  // energy ledger holds less
  static constexpr double unpaid = 0.15e-3;
  // Number of ticks. The work of the spindle that the cutting edges have not used yet must suffice for the force of the
  // cutting edges in this many ticks. Otherwise this force is reduced.
  static constexpr double teeth_ahead = 50;
};

/// Parameters that limit the force (limits.cpp).
struct LimitParameters {
  // N/s, largest force change while a bur cuts, including the change by the hand's motion
  static constexpr double drilling_slew = 18.5;
  // N; the limit drilling_slew may make the output force differ from the computed force by up to this, even if the
  // hand's own displacement causes the change of the force (held_back in limits.cpp)
  static constexpr double lag_limit = 0.05;
  // J; a debt of the energy ledger that is smaller than this counts as rounding error
  static constexpr double debt = 2e-9;
  // N, force that the coupling may always give, even if the energy ledger is empty
  static constexpr double unpaid_force = 0.1;
  // If the coupling's force is more than this factor times the force that the energy ledger can pay for, the ledger
  // begins to limit the force.
  static constexpr double unpaid_ratio = 2;
  // Limit of the ratio of two forces: the force that the hand feels, divided by the full force of the coupling. If the
  // ratio stays below this limit for rest_time, the force on the cutting edges begins to rise from the felt force to
  // the coupling's full force.
  static constexpr double little_felt = 0.5;
  // s. If the hand has felt less than the fraction little_felt of the coupling's force for a period of this length, the
  // force on the cutting edges begins to rise. The rise from the felt force to the coupling's force takes as long
  // again.
  static constexpr double rest_time = 0.1;
  // Factor. When the hand retreats by x, the force of the spring changes by k x (k: stiffness), and also because the
  // proxy moves. So k x times this factor is subtracted from the rise of the force that the slew limit allows.
  static constexpr double retreat_weight = 3;
  // Largest ratio of a force change to the change that the hand's displacement causes in the coupling's
  // spring. A larger force change counts as a step. (Documents and tests use the limit 1.1, see
  // docs/passivity.md.)
  static constexpr double spring_tolerance = 1.09;
};

/// Parameters of the passivity law for scenes of different sizes (law_for in servo.cpp).
struct ScaleParameters {
  // N/m, stiffness of the coupling in a tooth-sized scene, for which `credit` and `turning` are valid
  static constexpr double tooth_stiffness = 1000;
  static constexpr double credit = 1e-10;  // J, debt that the energy ledger may have in a tooth-sized scene
  static constexpr double turning = 1.2;   // m/s², expected acceleration of a hand whose motion is not known yet
};

/// Returns true if a position in the workbench frame W is finite and plausible for a hand.
inline bool in_workspace(const dvec3& p_W) noexcept {
  // for NaN the result is false, because every comparison with NaN is false
  return glm::dot(p_W, p_W) < MotionParameters::workspace * MotionParameters::workspace;
}

}  // namespace typodont::haptics
