// The servo: reads the hand's pose, cuts the tissue and returns the force, at 1 kHz or more.
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
class SoftSurface;
class SoftTissue;

/// Everything that the servo needs before its first tick. SI units.
struct ServoSettings {
  // N/m, stiffness of the coupling in enamel; other tissues scale this value by their own stiffness
  double stiffness = 1000;
  double damping = 2;  // N·s/m, damping along the contact normal
  bool friction = true;
  bool cutting = true;
  bool passivity = true;       // enables the passivity controller; the energy ledger always runs
  bool boundary_walls = true;  // enables one-sided walls: a bur in soft tissue is held back by harder tissue
  double force_limit = 20;     // N, limit of the force
  double torque_limit = 0.5;   // N·m, limit of the torque
  // The device can resist rotation (DeviceInfo); if false, the torque is only reported and not in the ledger
  bool gives_torque = true;
  double slew_limit = 0;  // N/s, limit of the force's rise; 0: no limit
  // m, position resolution of the device (DeviceInfo); above 0, the damper uses an estimated velocity
  double position_step = 0;
  // s, time in which the force rises from zero to full at the start, and falls to zero at the end
  double ramp_time = 15e-3;
  VibrationLaw vibration;  // vibration of the spindle, which the arm transmits to the hand; a band of 0 disables it
  ForceFilter filter = ForceFilter::kNone;  // force filter from the literature, for comparison
  double tick = 1e-3;                       // s, nominal period
  MaterialTable materials{};
  Tool tool;  // tool in the hand at the start
  // all tools that the hand can take, beginning with `tool`; empty: only `tool`. See tool_set()
  std::vector<Tool> tools;
  Spindle spindle;
  VoxelFrame frame;                             // frame of the tissue volume
  std::uint32_t laws = kServoLaws;              // version of the force laws; a replay uses the version in the recording
  std::shared_ptr<const ContactMethod> method;  // contact method; null: default_contact_method()
  std::shared_ptr<const SoftSurface> soft;  // soft tissue around the tooth (soft_tissue.h); null: the scene has none
};

/// The tools of a session. ServoTick::tool, Cut::tool and HandSample::tool are indices into this list.
inline std::span<const Tool> tool_set(const ServoSettings& settings) {
  return settings.tools.empty() ? std::span<const Tool>(&settings.tool, 1) : std::span<const Tool>(settings.tools);
}

/// State of the hand at one tick.
struct HandSample {
  Nanos t = 0;
  Pose X_WT;
  double pedal = 0;  // 0..1; for a tool with a thread -1..1, negative: backwards
  // Index of the wanted tool; the servo takes it as soon as pedal, spindle and tissue allow the change
  std::uint32_t tool = 0;
  std::uint32_t faults = 0;  // Fault bits of the device; if a bit of kNoPose is set, X_WT is not the pose of the hand
};
/// Faults that make the pose invalid and mean that the hand did not feel the last force. Servo::tick then returns zero
/// force, and starts anew with the next valid pose.
inline constexpr std::uint32_t kNoPose = bits(Fault::kBadInput) | bits(Fault::kDeviceLost);

/// Limit, as a fraction: a pedal below it counts as released, a spindle below this fraction of its free speed as
/// stopped.
inline constexpr double kPedalUp = 0.01;

/// Contact, cutting and force of one hand in one tissue. Servo thread only; tick() is noexcept, never allocates and
/// never locks. Deterministic: equal samples and equal snapshots give equal bits. The servo takes another tool in the
/// first tick in which the pedal is released, the spindle has stopped, and neither the old head nor the new one touches
/// tissue. So a tool change causes no force step.
class Servo {
 public:
  /// `settings` must be complete, including the frame. Throws Error if the contact method rejects the settings.
  explicit Servo(const ServoSettings& settings);
  ~Servo();
  Servo(Servo&&) noexcept;
  Servo& operator=(Servo&&) noexcept;

  /// Adopts a new snapshot from the carver and adds the cuts made since it was taken. Afterwards `fresh` contains the
  /// buffers of the old snapshot.
  void adopt(Snapshot& fresh) noexcept;

  /// Computes one tick. Returns true and fills `cut` if the tissue changed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut) noexcept;

  /// Sets new stiffnesses of the tissues, N/m, from the next tick on. Not for recorded sessions: a replay would not
  /// know the change.
  void set_stiffness(const PerTissue& stiffness) noexcept;

  /// Starts the end of a session: the force fades to zero within ramp_time.
  void ramp_out() noexcept;

  /// The snapshot in use.
  const Snapshot& snapshot() const noexcept;

  /// The soft tissue; null if the settings have none. Servo thread.
  SoftTissue* soft() noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The wanted centre of a snapshot, W, m. It lies between the proxy p_WG and the hand p_WT, at most travel / 2 from
/// the proxy. `travel`: m, see ContactModel::travel().
dvec3 snapshot_center_for(const dvec3& p_WG, const dvec3& p_WT, double travel) noexcept;
/// Returns true if a snapshot centred at `center_W` should be replaced by one centred at `wanted_W`.
inline bool snapshot_due_for(const dvec3& wanted_W, const dvec3& center_W, double travel) noexcept {
  const dvec3 off = wanted_W - center_W;
  return std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) > travel / 2;
}

/// The largest fraction of a step, 0..1, for which |rest + fraction · step| <= most. If no fraction satisfies this
/// condition, returns the fraction that minimises |rest + fraction · step|.
double largest_fraction(const dvec3& step, const dvec3& rest, double most);

}  // namespace typodont::haptics
