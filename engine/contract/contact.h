// What the servo says, once a tick, to everyone else: plain data, SI, frame W unless the name says otherwise.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont {

/// What went wrong in a tick. docs/safety.md: what sets each bit, what the force does, how soon, and what is said.
enum class Fault : std::uint32_t {
  kNone = 0,
  kBadInput = 1u << 0,         // hand pose not finite or not a unit quaternion: zero force
  kStalePatch = 1u << 1,       // a patch is due for over 20 ms: the force goes on, from the old one
  kPatchEdge = 1u << 2,        // the tool left the patch: the last contact's plane holds it; a free tool: zero
  kForceLimit = 1u << 3,       // the force was clipped to the device's limit
  kDeepPenetration = 1u << 4,  // the tool was found inside tissue (a leap, a late patch): it is led out slowly
  kDeviceLost = 1u << 5,       // the device stopped answering: zero force
  kRingFull = 1u << 6,         // a cut did not reach the carver: the force goes on
  kSlewLimit = 1u << 7,        // the force rose faster than the device allows
  kOverrun = 1u << 8,          // the tick took longer than its period: the force came late
  kLetGo = 1u << 9,            // the servo was late, and the motors were let go: the hand did not feel the last force
  kNoRoom = 1u << 10,  // filling that the pedal asks for found no place near the instrument's end: it was not put down
  kHeld = 1u << 11,    // the emergency key holds: no drill, and no force on the hand
  kWedged = 1u << 12,  // the hand has left a tool that its contacts hold: it is led back the way it came, if that helps
};
constexpr std::uint32_t bits(Fault fault) {
  return static_cast<std::uint32_t>(fault);
}

/// Version of the servo's force laws, which a recording keeps so that it replays to the bit. 4: the teeth's force fades
/// when the head comes free, where it ended in a step before. 3: a tool that the hand
/// has left is led back the way it came (the offset model). 2: a late patch gives way (docs/safety.md), a force that
/// the ledger does not pay for follows the ledger, and a ledger's small debt is forgiven. 1: before that; recordings
/// without the number.
inline constexpr std::uint32_t kServoLaws = 4;

/// One tick of the servo. Servo thread → everyone. Trivially copyable.
struct ServoTick {
  std::uint64_t index = 0;       // ticks since the servo started
  Nanos t = 0;                   // when the hand was sampled, since the session's start
  Pose X_WT;                     // the tool where the hand holds it (head centre; shank along +z)
  Pose X_WG;                     // the tool as held outside the tissue (the proxy): what is drawn
  dvec3 f_T_W{0, 0, 0};          // N, force on the hand
  dvec3 tau_T_W{0, 0, 0};        // N·m, torque on the hand about the head centre
  double pedal = 0;              // 0..1
  double depth = 0;              // m, |X_WG.p - X_WT.p|
  dvec3 n_C_W{0, 0, 0};          // unit, out of the tissue, at the contact; zero when free
  double contact_area = 0;       // m² of the head that touches tissue
  PerTissue removed{};           // m³ since the start
  Tissue tissue = Tissue::kAir;  // that the head touches most
  double spindle = 0;            // rad/s
  double cutting_power = 0;      // W, now
  double energy = 0;             // J, passivity observer: taken from the hand so far
  Nanos cpu_time = 0;            // thread CPU time of the tick; set by the loop that calls it
  std::uint32_t faults = 0;
  std::uint32_t patch = 0;  // number of the surface patch it was computed in; 0: none
  std::uint64_t cuts = 0;   // cuts made so far, this tick's included
  double spindle_energy =
      0;  // J, fed to the hand so far by the tangential force of cutting: the spindle's, not in `energy`
  std::uint32_t tool = 0;    // which of the session's tools is in the hand
  std::uint32_t level = 0;   // of detail at which the contact model feels the tissue; 0: the finest, or the only one
  dvec3 f_model_W{0, 0, 0};  // N, what the contact model asks for, before the servo's own slews, limits and ledger
};

/// Tissue cut away by one tick: the head swept in a straight line from A to B. Or, by a filling instrument, tissue
/// added: a ball about A's origin, but for the head at B. Servo → carver, debris, recorder.
struct Cut {
  std::uint64_t index = 0;  // 1, 2, 3 … without gaps
  std::uint64_t tick = 0;   // the tick that made it
  Nanos t = 0;
  Pose X_WA, X_WB;         // head centre and orientation before and after
  std::uint32_t tool = 0;  // which of the session's tools
  PerTissue removed{};     // m³ by this cut; negative where a filling was added
  dvec3 n_C_W{0, 0, 0};    // unit, out of the tissue
  double spindle = 0;      // rad/s, signed about the tool's z
  double fill_radius = 0;  // m, of the ball that was filled; 0: a cut
};

/// A piece of tissue that a cut set loose and that was taken out. Carver → debris, recorder.
struct LoosePiece {
  std::uint64_t cut = 0;    // that set it loose
  Nanos t = 0;              // of that cut
  dvec3 center_W{0, 0, 0};  // m, of the box around it
  double radius = 0;        // m, half the longest edge of that box
  PerTissue removed{};      // m³
};

/// When the servo took up a surface patch: with the cuts this makes a replay exact. Servo → recorder.
struct PatchUse {
  std::uint32_t patch = 0;       // its number, 1, 2, 3 …
  std::uint64_t first_tick = 0;  // the first tick computed in it
  std::uint64_t cuts = 0;        // cuts already in the tissue when it was cut out
  dvec3 center_W{0, 0, 0};       // m, where it was asked for
};

}  // namespace typodont
