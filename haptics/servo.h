// The computation of the servo thread: reads the hand's pose, cuts the tissue and returns the force, at 1 kHz or more.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/field_brick.h"
#include "haptics/contact/snapshot.h"
#include "haptics/coupling/filters.h"
#include "haptics/coupling/vibration.h"
#include "haptics/spindle.h"
#include "haptics/tool.h"

namespace typodont::haptics {

class ContactMethod;
class SoftSurface;
class SoftTissue;

/// Everything that the servo needs before its first tick, in SI units.
struct ServoSettings {
  // Stiffness of the coupling in contact with enamel, N/m. For another tissue, it is multiplied by the ratio of that
  // tissue's stiffness to enamel's.
  double stiffness = 1000;
  double damping = 2;  // N·s/m, damping of the coupling along the contact normal
  bool friction = true;
  bool cutting = true;
  // true: the passivity controller limits the force. The energy ledger is computed in any case.
  bool passivity = true;
  // true: a bur that cuts softer tissue is stopped at the border to harder tissue (one-sided walls)
  bool boundary_walls = true;
  double force_limit = 20;    // N, largest magnitude of the force
  double torque_limit = 0.5;  // N·m, largest magnitude of the torque
  // true: the device can output torque (DeviceInfo). false: the torque is only reported, and is not in the energy
  // ledger.
  bool gives_torque = true;
  double slew_limit = 0;  // N/s, largest rate at which the force may rise; 0: no limit
  // Position resolution of the device, m (DeviceInfo). Above 0, the damper uses an estimated velocity.
  double position_step = 0;
  // Time in which the force rises from zero at the start and falls to zero at the end, s.
  double ramp_time = 15e-3;
  // Spindle vibration that the device transmits to the hand; VibrationLaw::band = 0 disables it.
  VibrationLaw vibration;
  ForceFilter filter = ForceFilter::kNone;  // force filter of a published simulator, for comparisons
  double tick = 1e-3;                       // s, nominal period of a tick
  MaterialTable materials{};
  Tool tool;  // tool at the start of the session
  // All tools of the session, beginning with `tool`; empty: only `tool`. Use tool_set() to read them.
  std::vector<Tool> tools;
  Spindle spindle;
  VoxelFrame frame;                             // position and voxel size of the tissue volume's grid
  std::shared_ptr<const ContactMethod> method;  // contact method; null: default_contact_method()
  // Soft tissue around the tooth (soft_tissue.h); null: none.
  std::shared_ptr<const SoftSurface> soft;
};

/// Returns the tools of a session, indexed by ServoTick::tool, Cut::tool and HandSample::tool.
inline std::span<const Tool> tool_set(const ServoSettings& settings) {
  return settings.tools.empty() ? std::span<const Tool>(&settings.tool, 1) : std::span<const Tool>(settings.tools);
}

/// The hand's state in one tick.
struct HandSample {
  Nanos t = 0;
  Pose X_WT;
  double pedal = 0;  // pedal position 0..1; for a tool with a thread -1..1, where negative means backward
  // Index of the wanted tool. The servo changes the tool as soon as pedal, spindle and tissue permit it.
  std::uint32_t tool = 0;
  std::uint32_t faults = 0;  // fault bits of the device; if a bit of kNoPose is set, X_WT is not the pose of the hand
};
/// Faults that make the hand's pose invalid. Servo::tick() then returns zero force, and the energy ledger ignores the
/// motion until the next valid pose.
inline constexpr std::uint32_t kNoPose = bits(Fault::kBadInput) | bits(Fault::kDeviceLost);

/// Below this fraction, a pedal counts as released, and a spindle (speed divided by free speed) as stopped.
inline constexpr double kPedalUp = 0.01;

/// Computes contact, cutting and force of one hand in one tissue. Servo thread only; tick() never allocates or locks.
/// Deterministic: equal samples and snapshots give bit-identical ticks. The tool changes in the first tick in which the
/// pedal is released, the spindle has stopped, and neither old nor new head touches tissue; so a change causes no force
/// step.
class Servo {
 public:
  /// `settings` must be complete, including the frame. Throws Error if the contact method rejects the settings.
  explicit Servo(const ServoSettings& settings);
  ~Servo();
  Servo(Servo&&) noexcept;
  Servo& operator=(Servo&&) noexcept;

  /// Replaces the current snapshot by a new one from the carver, and repeats the cuts made since it was taken.
  /// Afterwards `fresh` contains the buffers of the old snapshot.
  void adopt(Snapshot& fresh) noexcept;

  /// Computes one tick. Returns true and sets `cut` if the tissue changed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut) noexcept;

  /// Sets the stiffness of each tissue from the next tick on, N/m. Not for recorded sessions, because the recording
  /// does not contain the change.
  void set_stiffness(const PerTissue& stiffness) noexcept;

  /// Begins the end of a session: the force falls to zero within ramp_time.
  void ramp_out() noexcept;

  /// Returns the snapshot that the servo currently uses.
  const Snapshot& snapshot() const noexcept;

  /// Returns the soft tissue, or null if the settings contain none. Servo thread only.
  SoftTissue* soft() noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the best centre of a new snapshot (m, frame W): on the line from proxy p_WG to hand p_WT, at most travel / 2
/// from the proxy. `lead`: m, expected motion of the tool; it moves the centre to at most 0.8 × travel from the proxy.
dvec3 snapshot_center_for(const dvec3& p_WG, const dvec3& p_WT, double travel, const dvec3& lead = dvec3(0)) noexcept;
/// Returns true if a snapshot centred at `center_W` should be replaced by a snapshot centred at `wanted_W`.
inline bool snapshot_due_for(const dvec3& wanted_W, const dvec3& center_W, double travel) noexcept {
  const dvec3 off = wanted_W - center_W;
  return std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) > travel / 2;
}

/// Returns the largest fraction 0..1 of `step` for which |rest + fraction · step| <= most, or the fraction that
/// minimises this length if no fraction satisfies the condition.
double max_fraction(const dvec3& step, const dvec3& rest, double most);

}  // namespace typodont::haptics
