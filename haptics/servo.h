// The servo: reads the hand's pose, cuts the tissue and returns the force, at 1 kHz or more.
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

/// The settings of the servo: everything that it needs before its first tick. SI units.
struct ServoSettings {
  // N/m, stiffness of the coupling in contact with enamel (1 N/mm). For another tissue, it is multiplied by the ratio
  // of the stiffness of this tissue to that of enamel.
  double stiffness = 1000;
  double damping = 2;  // N·s/m, damping along the contact normal
  bool friction = true;
  bool cutting = true;
  // true: the passivity controller limits the force; the energy ledger is computed in any case
  bool passivity = true;
  // true: harder tissue stops a bur that cuts in softer tissue (one-sided walls at borders)
  bool boundary_walls = true;
  double force_limit = 20;    // N, largest force
  double torque_limit = 0.5;  // N·m, largest torque
  // true: the device can output torque (DeviceInfo). false: the torque is only reported, and does not enter the energy
  // ledger.
  bool gives_torque = true;
  double slew_limit = 0;  // N/s, largest rate at which the force may rise; 0: no limit
  // m, position resolution of the device (DeviceInfo); if it is above 0, the damper uses an estimated velocity
  double position_step = 0;
  // s, time in which the force rises from zero to its full value at the start, and falls to zero at the end
  double ramp_time = 15e-3;
  // spindle vibration that the device transmits to the hand; VibrationLaw::band = 0 disables it
  VibrationLaw vibration;
  ForceFilter filter = ForceFilter::kNone;  // force filter from the literature, for comparisons
  double tick = 1e-3;                       // s, nominal period of a tick
  MaterialTable materials{};
  Tool tool;  // tool at the start of the session
  // All tools of the session, beginning with `tool`; empty: only `tool`. Use tool_set() to read them.
  std::vector<Tool> tools;
  Spindle spindle;
  VoxelFrame frame;                             // position and voxel size of the tissue volume's grid
  std::shared_ptr<const ContactMethod> method;  // contact method; null: default_contact_method()
  // soft tissue around the tooth (soft_tissue.h); null: the scene has no soft tissue
  std::shared_ptr<const SoftSurface> soft;
};

/// Returns the tools of a session. ServoTick::tool, Cut::tool and HandSample::tool are indices into this list.
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
/// Faults that make the hand's pose invalid. With such a fault, Servo::tick returns zero force, and its energy ledger
/// ignores the motion. The ledger continues with the next valid pose.
inline constexpr std::uint32_t kNoPose = bits(Fault::kBadInput) | bits(Fault::kDeviceLost);

/// A pedal counts as released if its value is below this fraction. A spindle counts as stopped if its speed, divided by
/// its free speed, is below this fraction.
inline constexpr double kPedalUp = 0.01;

/// Computes contact, cutting and force of one hand in one tissue. Servo thread only; tick() is noexcept, never
/// allocates and never locks. Deterministic: equal samples and equal snapshots give the same bits. The tool is changed
/// in the first tick in which the pedal is released, the spindle has stopped, and neither the old nor the new head
/// touches tissue. So a change of the tool causes no force step.
class Servo {
 public:
  /// `settings` must be complete, including the frame. Throws Error if the contact method rejects the settings.
  explicit Servo(const ServoSettings& settings);
  ~Servo();
  Servo(Servo&&) noexcept;
  Servo& operator=(Servo&&) noexcept;

  /// Replaces the present snapshot by a new one from the carver, and repeats the cuts that were made after the new one
  /// was taken. Afterwards `fresh` contains the buffers of the old snapshot.
  void adopt(Snapshot& fresh) noexcept;

  /// Computes one tick. Returns true and sets `cut` if the tissue changed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut) noexcept;

  /// Sets the stiffness of each tissue, N/m, from the next tick on. Not for recorded sessions, because the recording
  /// does not contain the change.
  void set_stiffness(const PerTissue& stiffness) noexcept;

  /// Begins the end of a session: the force falls to zero within ramp_time.
  void ramp_out() noexcept;

  /// Returns the tissue snapshot that the servo uses at present.
  const Snapshot& snapshot() const noexcept;

  /// Returns the soft tissue, or null if the settings contain none. Servo thread only.
  SoftTissue* soft() noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the best centre for a new snapshot in m, frame W. It lies on the line from the proxy p_WG to the hand p_WT,
/// at most travel / 2 from the proxy. `travel`: m, TissueBody::travel(). `lead`: m, motion of the tool in the next
/// milliseconds. It is added to the centre, which may then be up to 0.8 travel away from the proxy.
dvec3 snapshot_center_for(const dvec3& p_WG, const dvec3& p_WT, double travel, const dvec3& lead = dvec3(0)) noexcept;
/// Returns true if a snapshot centred at `center_W` should be replaced by a snapshot centred at `wanted_W`.
inline bool snapshot_due_for(const dvec3& wanted_W, const dvec3& center_W, double travel) noexcept {
  const dvec3 off = wanted_W - center_W;
  return std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) > travel / 2;
}

/// Returns the largest fraction 0..1 of `step` for which |rest + fraction · step| <= most. If no fraction fulfils this
/// condition, returns the fraction that minimises |rest + fraction · step|.
double largest_fraction(const dvec3& step, const dvec3& rest, double most);

}  // namespace typodont::haptics
