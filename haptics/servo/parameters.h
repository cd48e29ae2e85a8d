// The numbers of the servo's steps, each with its unit and its reason. Those that belong to a method of contact are in
// that method's folder.
#pragma once

#include "engine/base/pose.h"

namespace typodont::haptics {

/// The hand, from tick to tick (servo.cpp).
struct MotionParameters {
  static constexpr double hand_speed_limit = 2.0;  // m/s: what moves faster is a leap of the input, not a hand
  static constexpr double leap_time = 0.05;        // s that the proxy may take to follow a leap
  static constexpr double lost_distance = 0.02;    // m: a hand that comes back from so far off starts anew
  static constexpr double workspace = 100;         // m: no hand is as far away; a larger number is bad input
  static constexpr double longest_tick = 0.1;      // s: a longer one is a jump of the clock and counts as a nominal one
  static constexpr double stale_time = 0.02;       // s that a snapshot may be due before that is a fault
};

/// What a bur earns and spends (cutting.cpp).
struct CuttingParameters {
  static constexpr double budget_time =
      0.5;                                   // s of power that may wait for a voxel to yield or for a bur to land again
  static constexpr double held_time = 0.05;  // s of power that may wait at a wall, or under an edge that the hand draws
  static constexpr double owed_volume = 8e-12;  // m³ that a motor works for later where a tip broke in at once, …
  static constexpr double owed_voxels = 8;      // … and at least as many voxels
};

/// What the contact gives the hand (coupling.cpp).
struct CouplingParameters {
  static constexpr double stiffness_time = 4e-3;  // s, time constant of the stiffness felt and of the torque
  static constexpr double cut_damping_time =
      4e-3;                                   // s, time constant of the depth's rate for the damper of a cutting bur
  static constexpr double tissue_slew = 4;    // N/s, limit of the change by another tissue under the head
  static constexpr double damper_slew = 4;    // N/s, limit of the damper's change while cutting
  static constexpr double teeth_slew = 4;     // N/s, limit of the change of the teeth's tangential force
  static constexpr double waiting_slew = 16;  // N/s of the depth's own change above which tissue and damper wait
  static constexpr double total_slew = 18;    // N/s of all changes above which the teeth's force waits
  static constexpr double unpaid = 0.15e-3;   // J that harder tissue may store beyond what the ledger holds
  static constexpr double fade_time_of_laws_1 =
      0.1;                                   // s, time constant of a force without a snapshot, by the first laws
  static constexpr double teeth_ahead = 50;  // ticks for which the spindle's work must suffice, or its force shrinks
};

/// What bounds the force (limits.cpp).
struct LimitParameters {
  static constexpr double drilling_slew = 18.5;  // N/s, limit of the force's change while a bur cuts, hand included, …
  static constexpr double most_lag = 0.05;       // N … where the force need not stay behind by more than this
  static constexpr double debt = 2e-9;           // J of ledger debt that is more than rounding
  static constexpr double unpaid_force = 0.1;    // N that the coupling may give although the ledger holds nothing
  static constexpr double far_more = 2;          // ratio to the force that the ledger's energy is worth
};

/// The passivity law of a scene of another size (law_for in servo.cpp).
struct ScaleParameters {
  static constexpr double tooth_stiffness = 1000;  // N/m, coupling of a scene as large as a tooth, where …
  static constexpr double credit = 1e-10;          // … J that the ledger may be overdrawn by, and …
  static constexpr double turning = 1.2;  // … m/s² that a hand may do which has not shown how abruptly it moves
};

/// True if a position in W is finite and may be a hand's.
inline bool in_workspace(const dvec3& p_W) noexcept {
  return glm::dot(p_W, p_W) < MotionParameters::workspace * MotionParameters::workspace;  // false for NaN
}

}  // namespace typodont::haptics
