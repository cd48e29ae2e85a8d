// The data that the servo publishes once per tick, in SI units. Vectors and poses are in frame W unless the name states
// another frame.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont {

/// Faults of a tick, as bits. docs/safety.md lists for each bit its cause, the effect on the force, the delay and the
/// message.
enum class Fault : std::uint32_t {
  kNone = 0,
  kBadInput = 1u << 0,  // the hand's pose is not finite, or its quaternion does not have length 1: the force is zero
  /// A new patch (copy of the tissue around the tool) is more than 20 ms late. Until it arrives, the force is computed
  /// with the old patch.
  kStalePatch = 1u << 1,
  // The tool left the copy of the tissue around it (tissue patch). If the tool was in contact, the plane of the last
  // contact now replaces the tissue. Otherwise the force is zero.
  kPatchEdge = 1u << 2,
  kForceLimit = 1u << 3,  // the force was clipped to the device's limit
  // The tool was found inside the tissue, because the hand jumped or a new tissue copy came late. The proxy moves out
  // of the tissue slowly.
  kDeepPenetration = 1u << 4,
  kDeviceLost = 1u << 5,  // the device stopped answering: the force is zero
  // Contacts prevent the tool from following the hand away from the tissue. If possible, the tool moves back along the
  // path on which it came.
  kWedged = 1u << 6,
  kSlewLimit = 1u << 7,  // the force rose faster than the device allows, so its rate of change was limited
  kOverrun = 1u << 8,    // the tick took longer than its period, so the force was written late
  kLetGo = 1u << 9,  // the servo was late and the motors were switched off, so the hand did not receive the last force
  // The user presses the pedal of a filling instrument, but there is no free space near the tool, so nothing was
  // filled.
  kNoRoom = 1u << 10,
  kHeld = 1u << 11,  // the emergency key is on: the drill does not drill, and the hand feels no force
};
constexpr std::uint32_t bits(Fault fault) {
  return static_cast<std::uint32_t>(fault);
}

/// The result of one tick of the servo. All other threads read it. Trivially copyable.
struct ServoTick {
  std::uint64_t index = 0;  // number of ticks since the servo started
  Nanos t = 0;              // ns since the session's start, time at which the hand was sampled
  // Pose of the tool as the user holds it, measured by the haptic device; it may lie inside the tissue. The origin of
  // frame T is the centre of the tool's head, and z points along the shank.
  Pose X_WT;
  Pose X_WG;                     // pose of the proxy, which is the tool as it is drawn; it stays outside the tissue
  dvec3 f_T_W{0, 0, 0};          // N, frame W, force on the hand
  dvec3 tau_T_W{0, 0, 0};        // N·m, torque on the hand about the head centre
  double pedal = 0;              // position of the pedal, 0 (released) to 1
  double depth = 0;              // m, distance between hand and proxy: |X_WG.p - X_WT.p|
  dvec3 n_C_W{0, 0, 0};          // unit contact normal, pointing out of the tissue; zero if the tool has no contact
  double contact_area = 0;       // m², area of the head in contact with tissue
  PerTissue removed{};           // m³, per tissue: volume removed since the start
  Tissue tissue = Tissue::kAir;  // the tissue with the largest area of contact
  double spindle = 0;            // rad/s, rotation speed of the spindle
  double cutting_power = 0;      // W, power that cutting takes in this tick
  // J, energy that the hand has given to the device so far; negative: the hand has received energy (passivity observer)
  double energy = 0;
  Nanos cpu_time = 0;  // ns, thread CPU time of the tick; set by the loop that calls the servo
  std::uint32_t faults = 0;
  std::uint32_t patch = 0;  // number of the tissue patch used in this tick; 0: none
  std::uint64_t cuts = 0;   // number of cuts so far, including this tick's
  // J, energy that the spindle has given to the hand so far by the tangential cutting force. The member `energy` does
  // not include this energy.
  double spindle_energy = 0;
  double wear = 0;          // at equal power, a new tool would remove 1 + wear times as much tissue as this tool
  std::uint32_t tool = 0;   // index of the current tool in the session's list
  std::uint32_t level = 0;  // level of detail that the contact model uses; 0: the finest or the only level
  // N, force of the contact model before the servo's slew limit, force limit and passivity control (energy ledger).
  dvec3 f_model_W{0, 0, 0};
};

/// Tissue that the head removes in one tick. The head moves along a straight line from pose A to pose B. If the tool is
/// a filling instrument, the cut adds tissue instead: a ball around A's origin, without the volume of the head at B.
/// Servo → carver, debris, recorder.
struct Cut {
  std::uint64_t index = 0;  // number of the cut: 1, 2, 3 … without gaps
  std::uint64_t tick = 0;   // number of the tick that made the cut
  Nanos t = 0;
  Pose X_WA, X_WB;         // pose of the head before and after the cut; origin in the head's centre
  std::uint32_t tool = 0;  // tool that made the cut, as an index in the session's list of tools
  PerTissue removed{};     // m³, for each tissue: removed volume; negative: filled
  dvec3 n_C_W{0, 0, 0};    // unit normal of the contact, pointing out of the tissue
  double spindle = 0;      // rad/s, spindle speed about the tool's z, signed
  double fill_radius = 0;  // m, radius of the filled ball; 0: removes tissue
};

/// A piece of tissue that a cut separated from the rest. The carver removed the piece from the tissue. Carver → debris,
/// recorder.
struct LoosePiece {
  std::uint64_t cut = 0;    // number of the cut that separated the piece
  Nanos t = 0;              // ns, time of the cut
  dvec3 center_W{0, 0, 0};  // m, centre of the piece's bounding box
  double radius = 0;        // m, half the longest edge of the piece's bounding box
  PerTissue removed{};      // m³, for each tissue: its volume in the piece
};

/// The servo begins to use a new patch (copy of the tissue around the tool). Recordings contain these messages, because
/// a replay needs them to compute bit-identical forces. Servo → recorder.
struct PatchUse {
  std::uint32_t patch = 0;       // number of the tissue patch: 1, 2, 3 …
  std::uint64_t first_tick = 0;  // number of the first tick computed with this tissue patch
  std::uint64_t cuts = 0;        // number of cuts in the tissue when it was copied
  dvec3 center_W{0, 0, 0};       // m, requested centre of the tissue patch
};

}  // namespace typodont
