// Between ticks, one struct per step: Motion, Cutting, Coupling, Limits, and the model, in Servo::tick's order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "haptics/contact/contact_model.h"
#include "haptics/coupling/friction.h"
#include "haptics/coupling/passivity.h"
#include "haptics/coupling/tip.h"
#include "haptics/coupling/velocity_estimator.h"
#include "haptics/servo.h"
#include "haptics/servo/parameters.h"
#include "haptics/soft_tissue.h"

namespace typodont::haptics {

/// SI, W.
struct TickData {
  const HandSample& hand;  // unchecked
  ServoTick& out;
  Cut& cut;
  Pose X_WT{};               // checked, unit quaternion
  double dt = 0;             // s, measured time since the last tick
  dvec3 moved{0};            // m, since the last tick
  dvec3 turned{0};           // rad, since the last tick
  double given_to_hand = 0;  // J from the device, since the last tick
  bool jumped = false;       // faster than hand_speed_limit
};

/// If the tool may touch.
struct ContactTick : TickData {
  explicit ContactTick(const TickData& tick) noexcept : TickData(tick) {}

  ContactInput in;
  Contact contact;
  std::uint32_t faults = 0;
  SpindleLoad spindle{};
  double tangential = 0;    // edges' tangential / normal force
  double energy_ratio = 1;  // work of motor or hand / work at the material's specific energy
  dvec3 force{0}, torque{0}, normal{0};
  dvec3 spindle_force{0};   // N on the hand: edges and vibration
  dvec3 teeth_force{0};     // N of these, edges
  dvec3 spindle_torque{0};  // N·m, torque of the spindle on the hand
  dvec3 p_held{0};          // m, where the contact holds the tool
  double stored = 0;        // J, energy stored in the coupling
  double unlimited = 0;     // N, magnitude of `force` before the limits
  SoftTissue::Output soft;  // part of `force`
  /// Hard or soft.
  bool touching() const noexcept { return contact.touching || soft.touching; }
};

/// n times larger scenes with n times softer couplings have equal forces: expected motion and credit grow along, up to
/// the credit's limit. Not with a device: hands and encoder counts stay the same.
PassivityLaw law_for(const ServoSettings& settings);

/// Returns hardness 1 for all tissues: every tissue is as hard as its material.
inline PerTissue own_hardness() noexcept {
  PerTissue all;
  all.fill(1);
  return all;
}

struct Servo::State {
  /// State of the motion of hand and proxy.
  struct Motion {
    Pose X_WG;                   // pose of the proxy
    bool placed = false;         // true if X_WG is valid
    bool began_at_hand = false;  // true until tissue is known there
    bool inside = false;         // true if it began inside tissue and is not out yet: it does not cut
    bool started = false;        // true if the last tick had a valid pose
    Nanos began = 0;             // time at which the present sequence of valid poses began
    Nanos last_t = 0;
    Pose last_hand;
    // Orientation of the hand in the last input, and the same orientation normalised
    dquat came_R{0, 0, 0, 0}, R_WT{1, 0, 0, 0};
    double leap = 0;        // s, remaining time in which the proxy follows a jump of the hand's pose
    double due_for = 0;     // s, time for which a new snapshot has been due
    bool idle = false;      // true if the last tick left no force and no contact state
    bool released = false;  // true if the model's release() was called after the last contact
    double room = 0;        // m, distance that a free tool may still move before the model must compute a new clearance
  };
  /// State of the spindle, and of the energy that may be spent on the removal of tissue.
  struct Cutting {
    double speed = 0;  // rad/s, speed of the spindle without load
    double phase = 0;  // rad, angle of the spindle
    // J, energy that may be spent on the removal of tissue; negative: the removal has used more energy than the spindle
    // has supplied
    double budget = 0;
    // 0..1, power at a wall of harder tissue in the last tick, divided by the head's full power; 0: no wall
    double wall = 0;
    double wall_budget = 0;   // J, the part of the budget that may be spent at a wall of harder tissue
    double energy_ratio = 1;  // of the last tick (ContactTick)
    double feed = 0;          // m, smoothed advance per turn of a tool with known edges
    double spindle_work = 0;  // J, total work of cutting so far
  };
  /// State of the contact force.
  struct Coupling {
    double relative_stiffness = 1;        // factor on the stiffness in the settings, from the tissue under the head
    PerTissue tissue{};                   // for each tissue: its fraction of the tissue under the head
    PerTissue hardness = own_hardness();  // mean hardness of each tissue under the head, 0..1 (dense_tissue.h)
    double normal_force = 0;              // N, normal force in the last tick
    double head_force = 0;                // N, the part of normal_force that acts on the head (and not on the shank)
    dvec3 normal{0};
    // Unit vector: direction in which the contacts push the head. If a bur's cuts have used more energy than its motor
    // has delivered, the bur is slowed down; this limit counts as a contact, too.
    dvec3 pressed{0};
    double pressing = 0;  // N, component of head_force along `pressed`, times `teeth_fraction`
    // 0..1, fraction of the coupling's force that presses the cutting edges. It is 1, except for drills whose contact
    // with tissue is softened by additional limits (see lands()). For such a drill, it is the fraction of the last
    // tick's force that these limits left, or more if the hand has felt little force for a long time (press_teeth).
    double teeth_fraction = 1;
    // s, time for which the hand has felt less than the fraction LimitParameters::little_felt of the coupling's force.
    // Such a small force comes from the limits for drills that meet tissue (see lands()). The time decreases again
    // while the hand feels more. It is at most twice LimitParameters::rest_time.
    double unfelt_for = 0;
    FrictionState friction;
    TipState tip;
    double rate = 0;  // m/s, smoothed rate at which the penetration depth changes
    VelocityEstimator
        depth_speed;        // estimates the rate of the depth for a quantised position, whose differences are noisy
    double last_depth = 0;  // m, penetration depth in the last tick
    dvec3 torque{0};        // N·m, torque before the limits
    dvec3 teeth_force{0};   // N, force of the cutting edges before the limits
    explicit Coupling(double position_step) : depth_speed(position_step, 1) {}
  };
  /// State of the limits: the last force, and the energy that the energy ledger allows.
  struct Limits {
    PassivityLaw law;
    PassivityState passivity;
    double stored = 0;  // J, energy stored in the coupling in the last tick
    // J, energy that the coupling got without work of the hand: because the input jumped, or because the proxy led the
    // tool out of tissue. The energy ledger allows this energy while the contact lasts. When a contact ends, `given` is
    // set to the ledger's debt. So the debt does not count at the next contact.
    double given = 0;
    /// true if the energy ledger holds far less energy than the coupling stores; the ledger then limits the force
    bool unpaid = false;
    double ramp = 0;  // 0..1, factor on the force at start and end
    bool ending = false;
    dvec3 last_force{0};           // N, tissue's force in the last tick
    dvec3 last_torque{0};          // N·m, torque that the hand felt in the last tick
    dvec3 last_spindle_force{0};   // N, force of the spindle in the last tick
    dvec3 last_teeth_force{0};     // N, the part of last_spindle_force that the bur's cutting edges caused
    dvec3 last_sent{0};            // N, total force in the last tick
    dvec3 last_spindle_torque{0};  // N·m, torque of the spindle in the last tick
    double teeth_energy = 0;       // J, energy that the cutting edges have given to the hand so far
  };

  /// State of the friction on soft tissue.
  struct SoftContact {
    FrictionState friction;
    dvec3 p{0};  // m, position of the tool in the last contact
  };

  ServoSettings settings;
  std::span<const Tool> tools;  // tools in the settings
  std::uint32_t in_hand = 0;
  std::unique_ptr<ContactModel> model;
  const Snapshot* snapshot;  // tissue snapshot that the contact model uses
  double travel;             // m, distance that the tool may move before a new snapshot is due (travel() of the model)
  // true if rotations of the tool in the hand change the clearance, so that it must be computed again in every tick
  // (turns_matter() of the model)
  bool turns_matter;
  Motion motion;
  Cutting cutting;
  Coupling coupling;
  Limits limits;
  std::unique_ptr<SoftTissue> soft;  // null: the scene has no soft tissue
  SoftContact soft_contact;
  ServoTick sums;  // running totals: index, removed, energy, spindle_energy, cuts

  explicit State(const ServoSettings& s);
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  const Tool& tool() const noexcept { return tools[in_hand]; }
  /// Returns the speed (rad/s) of the unloaded spindle at full pedal with the tool in the hand.
  double free_speed() const noexcept { return tool().free_speed(settings.spindle.free_speed); }
  /// Mean material properties of the tissues under the head; 0 if there is no tissue.
  struct TissueMeans {
    double stiffness = 0;  // N/m, mean stiffness, scaled by the hardness
    double static_friction = 0, dynamic_friction = 0;
    Tissue most = Tissue::kAir;  // the most frequent tissue
  };
  TissueMeans tissue_means() const noexcept;
  /// How the tool's edges cut the tissues under the head.
  struct EdgeMeans {
    double specific_energy = 0;  // J/m³, of the materials, scaled by the hardness
    double energy_ratio = 1;     // energy per volume by the chips / specific energy
    double force_ratio = 0;      // tangential / normal force
  };
  EdgeMeans edge_means() const noexcept;

  /// Returns the limit of the energy ledger's debt, J. A greater debt is cancelled: it would allow no force, and
  /// without a force the hand could never pay the debt back. The limit is at most the credit of the passivity law.
  double most_debt() const noexcept { return std::min(LimitParameters::debt, limits.law.credit); }

  /// Returns the largest debt of the energy ledger, J, that is cancelled when a contact ends. Usually it is the energy
  /// `limits.given`, which was allowed during the contact. But a debt above most_debt() is cancelled completely,
  /// because it has other causes, for example late ticks, in which a force lasts longer than expected.
  double cancelled_debt() const noexcept { return sums.energy < -most_debt() ? -sums.energy : limits.given; }

  // The next functions are defined in servo.cpp:
  /// Handles a tick without a valid pose or without a hand: the force is zero, and the next valid tick begins anew.
  void rest(TickData& now, bool valid) noexcept;
  void begin_anew(const Pose& X_WT, Nanos t) noexcept;
  /// Updates the energy ledger by the energy that the device gave the hand since the last tick. Always inlined: a
  /// called function would read the hand's pose, which was just written, in pieces of another size, and this read would
  /// have to wait until the write is complete.
  [[gnu::always_inline]] inline void account(TickData& now, bool turns) noexcept;
  /// Updates the spindle's free speed, which follows the pedal with the time constant run_up_time.
  [[gnu::always_inline]] inline void run_spindle(const TickData& now) noexcept;
  /// Changes to the wanted tool if the spindle has stopped and neither that tool nor the present tool touches tissue.
  void change_tool(TickData& now) noexcept;
  /// Shortcut for a tool that is far from all tissue, now and in the last tick. Gives the same result as the full tick.
  /// Returns false and does nothing if a contact, a force, or a state of a contact may remain.
  [[gnu::always_inline]] inline bool move_free(TickData& now) noexcept;
  void fill_input(ContactTick& now) const noexcept;
  void watch_snapshot(ContactTick& now) noexcept;
  void watch_start(ContactTick& now) noexcept;
  /// What this tick's energy pays for. True, with the Cut: the tissue changed.
  bool remove(ContactTick& now) noexcept;
  void remember(ContactTick& now, const dvec3& felt_torque) noexcept;
  /// Only if `soft` is set.
  void report_soft(ContactTick& now) noexcept;

  // The next functions are defined in servo/cutting.cpp:
  /// J of this tick, from the last force.
  void earn(ContactTick& now) noexcept;
  void spend(ContactTick& now, double energy) noexcept;

  // The next functions are defined in servo/coupling.cpp.
  /// Coupling, damper, friction, edges; a penalty method's own force replaces the first two.
  void feel(ContactTick& now) noexcept;
  /// Into softened tissue, sticking on withdrawal.
  void sink_tip(ContactTick& now) noexcept;
  /// Yields and pushes away. Only if `soft` is set.
  void press_soft(ContactTick& now) noexcept;
  /// Adds the vibration of the spindle.
  void vibrate(ContactTick& now) noexcept;

  // The next functions are defined in servo/limits.cpp:
  /// Force, torque, slew, and ramps.
  void limit(ContactTick& now) noexcept;
  /// Only energy that the hand put in, or the ledger's credit. Returns what torque the device can render.
  dvec3 keep_passive(ContactTick& now) noexcept;

 private:
  double paid_fraction(const ContactTick& now) noexcept;
  /// N, tissue and edges, since the last tick.
  dvec3 force_change(const ContactTick& now) const noexcept;
  /// Further limits soften it.
  static bool lands(const ContactTick& now) noexcept;
  double held_back(const ContactTick& now, double change) const noexcept;
  double landing_fraction(const ContactTick& now, double at_stake) const noexcept;
  void press_teeth(const ContactTick& now) noexcept;
  void feel_nothing(ContactTick& now) noexcept;
  void couple(ContactTick& now, double depth) noexcept;
  void take_force(ContactTick& now) noexcept;
  double spare_change(const ContactTick& now, double depth) const noexcept;
  double follow_stiffness(const ContactTick& now, double depth, double wanted) noexcept;
  double damped(const ContactTick& now, double push, double depth) noexcept;
  void feel_teeth(ContactTick& now) noexcept;
  void fade_teeth(ContactTick& now) noexcept;
  void limit_teeth_energy(ContactTick& now) noexcept;
};

}  // namespace typodont::haptics
