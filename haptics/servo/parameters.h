// Of the servo tick's steps, each with unit and reason. Contact methods have theirs in their folders.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// Of the hand, per tick (servo.cpp).
struct MotionParameters {
  // m/s; faster is a jump
  static constexpr double hand_speed_limit = 2.0;
  static constexpr double leap_time = 0.05;  // s, for the proxy to follow a jump
  // m from the hand after an interruption; farther, the proxy restarts there
  static constexpr double lost_distance = 0.02;
  // m from W's origin; farther is illegal
  static constexpr double workspace = 100;
  // s; longer is a jump of the clock: nominal tick
  static constexpr double longest_tick = 0.1;
  // s overdue, from which a snapshot's lateness is a fault
  static constexpr double stale_time = 0.02;
};

/// Energy that a bur earns and spends (cutting.cpp).
struct CuttingParameters {
  // s; a pressing bur saves motor energy for a voxel, up to present power times this; without contact nothing
  static constexpr double budget_time = 0.5;
  // s; instead of budget_time at a border to harder tissue, or for a drawn edge
  static constexpr double held_time = 0.05;
  // m³ that a bur may remove on credit when it breaks in
  static constexpr double owed_volume = 8e-12;
  // voxels, at least, of owed_volume: above 0.1 mm, 8e-12 m³ would be less than eight
  static constexpr double owed_voxels = 8;
};

/// Parameters of the contact's force and torque (coupling.cpp).
struct CouplingParameters {
  // s, of felt stiffness and torque
  static constexpr double stiffness_time = 4e-3;
  // s, damper's velocity when a tool cuts or fills
  static constexpr double cut_damping_time = 4e-3;
  static constexpr double tissue_slew = 4;  // N/s, by a change of tissue
  static constexpr double damper_slew = 4;  // N/s, damper when cutting or filling
  static constexpr double teeth_slew = 4;   // N/s, edges' tangential force
  // N/s, normal force in all: depth first, then stiffness and damper
  static constexpr double waiting_slew = 16;
  // N/s, in all: the rest first, then the edges' force
  static constexpr double total_slew = 18;
  // J that the coupling may always store when tissue stiffens
  static constexpr double unpaid = 0.15e-3;
  // Ticks for which the spindle's unused work must cover the edges' force, or it is reduced.
  static constexpr double teeth_ahead = 50;
};

/// Parameters that limit the force (limits.cpp).
struct LimitParameters {
  // N/s while a bur cuts, with the hand's motion
  static constexpr double drilling_slew = 18.5;
  // N that drilling_slew may hold back of the hand's own change (held_back in limits.cpp)
  static constexpr double lag_limit = 0.05;
  // J, below which a debt is rounding
  static constexpr double debt = 2e-9;
  // N, always allowed
  static constexpr double unpaid_force = 0.1;
  // Coupling's force / payable force, from which the ledger limits.
  static constexpr double unpaid_ratio = 2;
  // Felt / full coupling force; below it for rest_time, the edges' force rises from the felt to the full one.
  static constexpr double little_felt = 0.5;
  // s below little_felt until the edges' force begins to rise; the rise takes as long again.
  static constexpr double rest_time = 0.1;
  // Factor on k x (stiffness, retreat), taken off the allowed rise, because the proxy moves too.
  static constexpr double retreat_weight = 3;
  // Force change / that of the hand's displacement in the spring; more is a step. (Documents and tests: 1.1,
  // docs/passivity.md.)
  static constexpr double spring_tolerance = 1.09;
};

/// For scenes of different sizes (law_for in servo.cpp).
struct ScaleParameters {
  // N/m, at tooth size, for which `credit` and `turning` hold
  static constexpr double tooth_stiffness = 1000;
  static constexpr double credit = 1e-10;  // J of debt, at tooth size
  static constexpr double turning = 1.2;   // m/s², of an unknown hand
};

/// W.
inline bool in_workspace(const dvec3& p_W) noexcept {
  // false for NaN
  return glm::dot(p_W, p_W) < MotionParameters::workspace * MotionParameters::workspace;
}

}  // namespace typodont::haptics
