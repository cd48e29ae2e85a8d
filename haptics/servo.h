// The servo: hand pose in, force out, at 1 kHz or more, cutting the tissue on the way.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "haptics/coupling/filters.h"
#include "haptics/coupling/vibration.h"
#include "haptics/snapshot.h"
#include "haptics/spindle.h"
#include "haptics/tool.h"

namespace typodont::haptics {

class ContactMethod;

/// Everything a run needs to know before its first tick. SI.
struct ServoSettings {
  double stiffness = 1000;  // N/m, virtual coupling; what enamel feels. Other tissues scale with their own stiffness
  double damping = 2;       // N·s/m, along the contact normal
  bool friction = true;
  bool cutting = true;
  bool passivity = true;       // the controller; the ledger runs always
  bool boundary_walls = true;  // one-sided walls from soft to hard tissue
  double force_limit = 20;     // N
  double torque_limit = 0.5;   // N·m
  bool gives_torque =
      true;  // the hand's device resists turns (DeviceInfo); else its torque is for show, not in the ledger
  double slew_limit = 0;     // N/s that the force may rise by; 0: as it comes
  double position_step = 0;  // m, of the hand's device (DeviceInfo); the damper then goes by an estimate of velocity
  double ramp_time = 15e-3;  // s from nothing to the whole force at the start, and back at the end
  VibrationLaw vibration;    // of the spindle, through the arm; without a band there is none
  ForceFilter filter = ForceFilter::kNone;  // for comparison with the literature
  double tick = 1e-3;                       // s, nominal period
  MaterialTable materials{};
  Tool tool;                // in the hand at first
  std::vector<Tool> tools;  // all that can be taken up, `tool` first; empty: only that one. See tool_set()
  Spindle spindle;
  VoxelFrame frame;                             // of the tissue volume
  std::uint32_t laws = kServoLaws;              // version of the force laws; a replay takes the recording's
  std::shared_ptr<const ContactMethod> method;  // of contact; null: default_contact_method()
};

/// The tools of a session, as ServoTick::tool, Cut::tool and HandSample::tool count them.
inline std::span<const Tool> tool_set(const ServoSettings& settings) {
  return settings.tools.empty() ? std::span<const Tool>(&settings.tool, 1) : std::span<const Tool>(settings.tools);
}

/// The hand at one tick.
struct HandSample {
  Nanos t = 0;
  Pose X_WT;
  double pedal = 0;          // 0..1; down to -1, backwards, of a tool with a thread
  std::uint32_t tool = 0;    // the one that is wanted: taken up as soon as pedal, drill and tissue allow it
  std::uint32_t faults = 0;  // Fault bits of the device; with one of kNoPose the pose is not where the hand is
};
/// The hand is not where the sample says, nor did it feel the last force: Servo::tick gives none, and begins anew after
/// it.
inline constexpr std::uint32_t kNoPose = bits(Fault::kBadInput) | bits(Fault::kDeviceLost);

/// A pedal below this, of its range 0..1, is up; a spindle below this fraction of its free speed stands.
inline constexpr double kPedalUp = 0.01;

/// One hand in one tissue. Servo thread only; tick() is noexcept, never allocates, never locks, is deterministic: equal
/// samples and equal snapshots give equal bits. Another tool is taken up in the first tick in which the pedal is up,
/// the drill stands, and neither the old head nor the new one touches anything: the force cannot jump.
class Servo {
 public:
  /// `settings` must be complete, their frame included. Throws Error where the contact method refuses them.
  explicit Servo(const ServoSettings& settings);
  ~Servo();
  Servo(Servo&&) noexcept;
  Servo& operator=(Servo&&) noexcept;

  /// Takes up a fresh snapshot from the carver, brings it up to date with the cuts made since it was taken, and leaves
  /// the old one's buffers in its place.
  void adopt(Snapshot& fresh) noexcept;

  /// One tick. `cut` is filled and true returned when tissue was removed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut) noexcept;

  /// Other stiffnesses of the tissues, N/m, from the next tick on: where tissue is being made, and nothing recorded.
  void set_stiffness(const PerTissue& stiffness) noexcept;

  /// From now on the force fades within ramp_time; for the end of a session.
  void ramp_out() noexcept;

  /// The tissue that it works in.
  const Snapshot& snapshot() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Where a snapshot should lie, m: between the tool outside the tissue and the hand that pulls it, `travel` in m.
dvec3 snapshot_center_for(const dvec3& p_WG, const dvec3& p_WT, double travel) noexcept;
/// True when a snapshot that lies around `center_W` should be replaced by one around `wanted_W`.
inline bool snapshot_due_for(const dvec3& wanted_W, const dvec3& center_W, double travel) noexcept {
  const dvec3 off = wanted_W - center_W;
  return std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) > travel / 2;
}

/// The largest fraction of a step, 0..1, with |rest + fraction · step| <= most, or the one that comes nearest to that.
double largest_fraction(const dvec3& step, const dvec3& rest, double most);

}  // namespace typodont::haptics
