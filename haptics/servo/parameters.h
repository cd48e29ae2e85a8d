// Parameters of the steps of a servo tick, with unit and reason. Those of the contact methods are in their folders.
#pragma once

#include <cstdint>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// Checks of the hand's motion in each tick (servo.cpp).
struct MotionParameters {
  // m/s; a faster motion counts as a jump
  static constexpr double hand_speed_limit = 2.0;
  static constexpr double leap_time = 0.05;  // s, time in which the proxy follows a jump
  // m; if proxy and hand are farther apart after an interruption, the proxy starts again at the hand
  static constexpr double lost_distance = 0.02;
  // m; a pose farther from the origin of frame W is refused
  static constexpr double workspace = 100;
  // s; a longer tick is a jump of the clock, and the nominal tick is used instead
  static constexpr double longest_tick = 0.1;
  // s; a fault is reported if a new snapshot is overdue for longer
  static constexpr double stale_time = 0.02;
};

/// Energy that a bur receives and spends (cutting.cpp).
struct CuttingParameters {
  // s; a bur in contact saves energy until it suffices for the next voxel, at most its current power × this time
  static constexpr double budget_time = 0.5;
  // s; used instead of budget_time at a border to harder tissue, and for a scraping edge
  static constexpr double held_time = 0.05;
  // m³ that a bur entering tissue may remove before the motor has supplied the energy
  static constexpr double owed_volume = 8e-12;
  // Lower limit of the volume owed_volume, in voxels. It holds for voxels above 0.1 mm: eight of them exceed 8e-12 m³.
  static constexpr double owed_voxels = 8;
};

/// Parameters of the contact's force and torque (coupling.cpp). Edges: the cutting edges of the tool.
struct CouplingParameters {
  // s, time constant of the filters for the felt stiffness and the torque
  static constexpr double stiffness_time = 4e-3;
  // s, time constant of the filter for the damper's velocity when cutting or filling
  static constexpr double cut_damping_time = 4e-3;
  static constexpr double tissue_slew = 4;  // N/s, largest rate at which a change of tissue changes the force
  static constexpr double damper_slew = 4;  // N/s, largest rate of change of the damper's force when cutting or filling
  static constexpr double teeth_slew = 4;   // N/s, largest rate of change of the tangential force on the cutting edges
  // N/s; stiffness and damper may change the normal force by at most this rate minus the rate that the depth causes
  static constexpr double waiting_slew = 16;
  // N/s; the force on the cutting edges may change only so far that the total force changes no faster than this
  static constexpr double total_slew = 18;
  // J that the coupling may store without work of the hand when the tissue becomes stiffer
  static constexpr double unpaid = 0.15e-3;
  // The force on the cutting edges is reduced if the spindle's remaining work would last for fewer ticks than this, at
  // the energy per tick that the force takes now.
  static constexpr double teeth_ahead = 50;
};

/// The proxy's orientation, if tissue holds it (turn.cpp).
struct TurnParameters {
  // N·m/rad, stiffness of the spring between the orientations of hand and proxy, on enamel at the coupling's stiffness.
  // Ten degrees are 0.17 N·m, below the limit of arms with torque.
  static constexpr double stiffness = 1;
  // Voxels; largest motion per tick, by the proxy's rotation, of the contact that is farthest from the head's centre.
  // Below the distance at which tissue is found.
  static constexpr double arc = 0.5;
  // voxels, overlap that is not corrected: larger than the error of planes after a tick's motion in a narrow hole
  static constexpr double overlap = 0.05;
  // voxels, largest overlap of a contact that one tick corrects
  static constexpr double led_out = 0.1;
  // Factors on the fraction of a step that is made: after a reversed step, and after another; smallest fraction.
  static constexpr double shorter = 0.5, longer = 1.25, shortest = 1e-3;
  // N/s; between opposed walls, the proxy's motion changes the force at most this much faster than the hand's motion
  static constexpr double slew = 20;
  // smallest relative stiffness for which `slew` limits the motion
  static constexpr double softest = 0.05;
  // how often a tick may compute the planes that hold the tool exactly, and search again
  static constexpr int refining_rounds = 4;
  static constexpr double rounding = 1e-9;  // rad; a smaller difference of orientations counts as none
  // Contacts are opposed if the length of the sum of their pushes (vectors) is below this × the sum of the lengths.
  static constexpr double opposed = 0.7;
  // voxels, depth below the surface at which a contact's tissue is read
  static constexpr double felt_below = 0.5;
};

/// Parameters that limit the force (limits.cpp). Edges: the cutting edges of the tool.
struct LimitParameters {
  // N/s, largest rate at which the force of a cutting bur changes, including the change by the hand's motion
  static constexpr double drilling_slew = 18.5;
  // N; if the hand's own motion changes the force, drilling_slew delays at most this part of the change (held_back())
  static constexpr double lag_limit = 0.05;
  // J; a smaller energy deficit counts as rounding error
  static constexpr double deficit = 2e-9;
  // N, force that the passivity controller allows even if its energy ledger contains no energy
  static constexpr double unpaid_force = 0.1;
  // Ratio of the felt force to the computed force. If it stays lower than this for rest_time, the force that presses
  // the edges on the tissue increases from the felt to the computed force.
  static constexpr double little_felt = 0.5;
  // s; after this time with little felt force (little_felt), the force that presses the edges begins to increase
  static constexpr double rest_time = 0.1;
  // In retreat with too little energy, the force may grow per tick by: slew limit − this × stiffness × hand's retreat.
  static constexpr double retreat_weight = 3;
  // A change of the force counts as a step if it exceeds this factor × stiffness × displacement of the hand. Slightly
  // below the 1.1 that documents promise and tests allow (docs/passivity.md).
  static constexpr double spring_tolerance = 1.09;
};

/// Adapts the law of passivity to scenes of different sizes (law_for in servo.cpp).
struct ScaleParameters {
  // N/m, stiffness of a tooth scene. The values `credit` and `turning` below are for this stiffness.
  static constexpr double tooth_stiffness = 1000;
  static constexpr double credit = 1e-10;  // J, allowed energy deficit in a tooth scene
  static constexpr double turning = 1.2;   // m/s², largest acceleration expected of a hand in a tooth scene
};

/// Returns true if the point is in the workspace (W).
inline bool in_workspace(const dvec3& p_W) noexcept {
  // The comparison is false for NaN.
  return glm::dot(p_W, p_W) < MotionParameters::workspace * MotionParameters::workspace;
}

}  // namespace typodont::haptics
