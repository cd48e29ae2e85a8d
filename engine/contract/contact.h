// The data that the servo publishes once per tick. Plain data in SI units, in frame W unless the name says otherwise.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont {

/// Faults of a tick. docs/safety.md lists for each bit its cause, the effect on the force, the delay and the message.
enum class Fault : std::uint32_t {
  kNone = 0,
  kBadInput = 1u << 0,    // the hand's pose is not finite or not a unit quaternion: zero force
  kStalePatch = 1u << 1,  // a new patch is more than 20 ms late: the force is computed in the old patch
  // the tool left the patch: the last contact plane continues to hold a tool in contact; a free tool gets zero force
  kPatchEdge = 1u << 2,
  kForceLimit = 1u << 3,  // the force was clipped to the device's limit
  // the tool was found inside tissue (a jump of the hand, or a late patch): the proxy moves out slowly
  kDeepPenetration = 1u << 4,
  kDeviceLost = 1u << 5,  // the device stopped answering: zero force
  kRingFull = 1u << 6,    // the ring to the carver was full and a cut was lost: the force continues
  kSlewLimit = 1u << 7,   // the force rose faster than the device allows: its rate of change was limited
  kOverrun = 1u << 8,     // the tick took longer than its period, so the force was written late
  kLetGo = 1u << 9,       // the servo was late and the motors were released: the hand did not receive the last force
  kNoRoom = 1u << 10,     // the pedal requests filling, but there is no free space near the tool: nothing was placed
  kHeld = 1u << 11,       // the emergency key is on: no drilling, and no force on the hand
  // contacts hold the tool while the hand moves away from it: the tool returns along its own path if this helps
  kWedged = 1u << 12,
};
constexpr std::uint32_t bits(Fault fault) {
  return static_cast<std::uint32_t>(fault);
}

/// Version of the servo's force laws. A recording stores it, so that its replay gives the same bits. 8: a drilling tool
/// that lands hard feels no force steps beyond those of the hand's own motion (docs/passivity.md). 7: an implant drill
/// that moves along its axis cuts only at its end; the cutting law over its end is evaluated at coarser points, where
/// tool voxels are much finer than the tissue's; in the packing model, heads are overlapping rings of spheres whose
/// overlaps count once, the projection begins with the last pushes, a retreating tool is led back faster in scenes with
/// large forces, and the hole that a detached sphere leaves is no larger than its remainder. 6: the cutting law over an
/// implant drill's end is computed in floats. 5: a fast rotation of a long head is cut in fewer straight parts, without
/// the blocks from which the head recedes; the search of an instrument that fills keeps its speed limit, too. 4: the
/// tangential force of the blades fades when the head comes free; before, it ended in a step. 3: if contacts hold the
/// tool away from the hand, the tool returns along its own path (offset model). 2: a late patch gives way
/// (docs/safety.md); a force that the energy ledger does not cover follows the ledger; a small debt of the ledger is
/// cancelled. 1: the laws before version 2; used for recordings without a version.
inline constexpr std::uint32_t kServoLaws = 8;

/// One tick of the servo. Servo thread → everyone. Trivially copyable.
struct ServoTick {
  std::uint64_t index = 0;       // number of ticks since the servo started
  Nanos t = 0;                   // ns, time at which the hand was sampled, since the session's start
  Pose X_WT;                     // the tool at the hand's pose (head centre; shank along +z)
  Pose X_WG;                     // the proxy: the tool's pose held outside the tissue; this pose is drawn
  dvec3 f_T_W{0, 0, 0};          // N, force on the hand
  dvec3 tau_T_W{0, 0, 0};        // N·m, torque on the hand about the head centre
  double pedal = 0;              // 0..1
  double depth = 0;              // m, |X_WG.p - X_WT.p|
  dvec3 n_C_W{0, 0, 0};          // unit contact normal, pointing out of the tissue; zero if the tool has no contact
  double contact_area = 0;       // m², area of the head in contact with tissue
  PerTissue removed{};           // m³ removed since the start
  Tissue tissue = Tissue::kAir;  // the tissue with the largest area of contact
  double spindle = 0;            // rad/s, speed of the spindle
  double cutting_power = 0;      // W, present cutting power
  double energy = 0;             // J, passivity observer: energy taken from the hand so far
  Nanos cpu_time = 0;            // ns, thread CPU time of the tick; set by the loop that calls the servo
  std::uint32_t faults = 0;
  std::uint32_t patch = 0;  // number of the surface patch in which the tick was computed; 0: none
  std::uint64_t cuts = 0;   // number of cuts so far, including this tick's
  // J, energy that the spindle fed to the hand so far, through the tangential cutting force; `energy` does not
  // include it
  double spindle_energy = 0;
  std::uint32_t tool = 0;   // index of the tool in the hand, among the session's tools
  std::uint32_t level = 0;  // level of detail that the contact model uses; 0: the finest or the only level
  // N, the contact model's force before the servo applies its slew limits, force limit and energy ledger
  dvec3 f_model_W{0, 0, 0};
};

/// Tissue removed in one tick: the head swept in a straight line from A to B. A filling instrument adds tissue instead:
/// a ball around A's origin without the head's volume at B. Servo → carver, debris, recorder.
struct Cut {
  std::uint64_t index = 0;  // 1, 2, 3 … without gaps
  std::uint64_t tick = 0;   // number of the tick that made the cut
  Nanos t = 0;
  Pose X_WA, X_WB;         // head centre and orientation before and after the cut
  std::uint32_t tool = 0;  // index among the session's tools
  PerTissue removed{};     // m³ removed by this cut; negative for a filling
  dvec3 n_C_W{0, 0, 0};    // unit normal, pointing out of the tissue
  double spindle = 0;      // rad/s, signed about the tool's z
  double fill_radius = 0;  // m, radius of the filled ball; 0: this is a cut
};

/// A piece of tissue that a cut separated from the rest and that was then removed. Carver → debris, recorder.
struct LoosePiece {
  std::uint64_t cut = 0;    // number of the cut that separated it
  Nanos t = 0;              // time of that cut
  dvec3 center_W{0, 0, 0};  // m, centre of the piece's bounding box
  double radius = 0;        // m, half the longest edge of the bounding box
  PerTissue removed{};      // m³
};

/// The first tick in which the servo used a surface patch. With these records and the cuts a replay is exact. Servo →
/// recorder.
struct PatchUse {
  std::uint32_t patch = 0;       // number of the patch: 1, 2, 3 …
  std::uint64_t first_tick = 0;  // number of the first tick that was computed in this patch
  std::uint64_t cuts = 0;        // number of cuts that the tissue contained when the patch was copied
  dvec3 center_W{0, 0, 0};       // m, requested centre of the patch
};

}  // namespace typodont
