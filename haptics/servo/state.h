// State between ticks, one struct for each step, in the order of Servo::tick: Motion, Cutting, Coupling, Limits.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/missing_snapshot.h"
#include "haptics/coupling/friction.h"
#include "haptics/coupling/passivity.h"
#include "haptics/coupling/tip.h"
#include "haptics/coupling/velocity_estimator.h"
#include "haptics/servo.h"
#include "haptics/servo/nearest_step.h"
#include "haptics/servo/parameters.h"
#include "haptics/soft_tissue.h"

namespace typodont::haptics {

/// Data of the current tick. SI units, frame W.
struct TickData {
  const HandSample& hand;  // input, not checked yet
  ServoTick& out;
  Cut& cut;
  Pose X_WT{};               // checked pose of the hand, with a unit quaternion
  double dt = 0;             // s, measured time since the last tick
  dvec3 moved{0};            // m, displacement of the hand since the last tick
  dvec3 turned{0};           // rad, rotation of the hand since the last tick
  double given_to_hand = 0;  // J, energy that the device gave to the hand since the last tick
  bool jumped = false;       // true: the hand moved faster than hand_speed_limit
};

/// Additional data if the tool may touch tissue.
struct ContactTick : TickData {
  explicit ContactTick(const TickData& tick) noexcept : TickData(tick) {}

  ContactInput in;
  Contact contact;
  Felt felt;
  std::uint32_t faults = 0;
  double tangential = 0;    // tangential force of the edges divided by their normal force
  double energy_ratio = 1;  // work of motor or hand divided by (specific energy of the material × removed volume)
  dvec3 force{0}, torque{0}, normal{0};
  dvec3 spindle_force{0};   // N, force on the hand by edges and vibration
  dvec3 teeth_force{0};     // N, part of spindle_force that the edges cause
  dvec3 spindle_torque{0};  // N·m, torque of the spindle on the hand
  dvec3 p_held{0};          // m, position in which the contact or softened tissue holds the tool's origin
  double stored = 0;        // J, energy stored in the coupling
  double unlimited = 0;     // N, magnitude of `force` before the limits
  SoftTissue::Output soft;  // part of `force` that soft tissue causes
  /// Returns true if the tool touches hard or soft tissue.
  bool touching() const noexcept { return contact.touching || soft.touching; }
};

/// Law of passivity for a scene. In a scene n times larger than a tooth, the coupling is n times softer: the same force
/// needs n times the motion. So expected motion and energy credit are multiplied by n, except for a real device.
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
    bool began_at_hand = false;  // true: the proxy started at the hand; it is not yet known whether in tissue
    bool inside = false;         // true: the tool started inside tissue and is not out yet, so it does not cut
    bool started = false;        // true if the last tick had a valid pose
    Nanos began = 0;             // ns, start of the current sequence of valid poses
    Nanos last_t = 0;
    Pose last_hand;
    // orientation of the hand in the last tick: as received, and normalised
    dquat came_R{0, 0, 0, 0}, R_WT{1, 0, 0, 0};
    double leap = 0;         // s, remaining time in which the proxy follows a jump of the hand
    double due_for = 0;      // s, time for which a new snapshot has been due
    bool idle = false;       // true: the last tick left no force or contact
    bool released = false;   // true: the model's release() was called after the last contact
    double free_travel = 0;  // m, distance that a free tool may move before the clearance is computed again
  };
  /// State of the spindle, and of the energy that may be spent on the removal of tissue.
  struct Cutting {
    double speed = 0;  // rad/s, speed of the spindle
    double phase = 0;  // rad, angle of the spindle
    // J, energy for removal; negative: the removal has used more energy than the spindle supplied
    double budget = 0;
    // 0..1, fraction of the cutting power that the head used at a border to harder tissue in the last tick; 0: none
    double wall = 0;
    double wall_budget = 0;   // J, part of `budget` that may be used at a border to harder tissue
    double energy_ratio = 1;  // ContactTick::energy_ratio of the last tick
    double feed = 0;          // m, smoothed advance of the tool per turn, if its edges are known
    double spindle_work = 0;  // J, total work of cutting so far
  };
  /// Orientation of the proxy, if tissue holds it (turn.cpp).
  struct Turning {
    // A contact that holds the tool. x: m, relative to the head's centre. n: unit normal. push: m, force / stiffness
    struct Hold {
      dvec3 x, n;
      double push;
    };
    bool possible = false;  // true: the device renders torque, and the tool in the hand can feel it
    bool lags = false;      // true: the proxy has the orientation R, not the hand's
    dquat R{1, 0, 0, 0};
    dvec3 twist{0};  // rad, rotation from the hand's orientation to R, if `lags`
    // 0..1, fractions of the steps of orientation and position towards their goals; smaller after steps that reverse
    double turn = 1, follow = 1;
    dvec3 last_turn{0}, last_rest{0};  // m, last full steps
    int count = 0;                     // number of `holds`
    std::array<Hold, 6> holds{};
    double push = 0;       // m, sum of all pushes
    dvec3 lever{0};        // m, mean of the contacts' positions, weighted with their pushes
    dvec3 normal{0};       // normal of the contact with the largest push
    bool opposed = false;  // true: contacts push in different directions, as in a hole
    std::array<NearPlane, kMaxNearPlanes> planes;
    StepPlanes bounds;
  };
  /// State of the contact force.
  struct Coupling {
    double relative_stiffness = 1;        // factor on the settings' stiffness; depends on the tissue under the head
    PerTissue tissue{};                   // fraction of each tissue under the head
    PerTissue hardness = own_hardness();  // mean hardness of each tissue under the head, 0..1 (dense_tissue.h)
    double normal_force = 0;              // N, normal force in the last tick
    double head_force = 0;                // N, part of normal_force on the head, not the shank
    dvec3 normal{0};
    // Unit vector, direction in which the contacts push the head. A bur whose cuts have used more energy than the
    // motor supplied is slowed down; this limit counts as a contact.
    dvec3 pressed{0};
    double pressing = 0;  // N, `teeth_fraction` × component of head_force along `pressed`
    // 0..1, fraction of the coupling's force that presses the cutting edges. For a cutting tool (lands()): limited
    // force / unlimited force; if this ratio is small for long, it rises to 1 (press_teeth()). Other tools: 1.
    double teeth_fraction = 1;
    // s, time for which the hand has felt less than LimitParameters::little_felt of the coupling's force, because of
    // the limits for cutting tools (lands()). Decreases while the hand feels more; at most twice rest_time.
    double unfelt_for = 0;
    FrictionState friction;
    TipState tip;
    double rate = 0;  // m/s, filtered rate of change of the penetration depth
    VelocityEstimator
        depth_speed;        // estimates the rate of the depth for a quantised position, whose differences are noisy
    double last_depth = 0;  // m, penetration depth in the last tick
    dvec3 torque{0};        // N·m, torque before the limits
    dvec3 teeth_force{0};   // N, force of the cutting edges before the limits
    // Penalty method without tissue at the tool (bridge_springs()).
    MissingSnapshot missing;
    bool bridged = false;    // true: in the last tick, a plane replaced the springs
    bool returning = false;  // true: the springs' force returns after the plane, at a limited rate
    explicit Coupling(double position_step) : depth_speed(position_step, 1) {}
  };
  /// State of the limits: the last force, and the energy that the energy ledger allows.
  struct Limits {
    PassivityLaw law;
    PassivityState passivity;
    double stored = 0;  // J, energy stored in the coupling in the last tick
    // J, energy that the coupling received without work of the hand, by a jump or while the proxy was moved out of
    // tissue. This energy may return to the hand during the contact. Without contact: the ledger's deficit.
    double given = 0;
    /// true: the carver was late, and since then the ledger has had less energy than the coupling stores
    bool unpaid = false;
    double ramp = 0;  // 0..1, factor on the force that rises at the start of a session and falls at its end
    bool ending = false;
    dvec3 last_force{0};           // N, tissue's force in the last tick
    dvec3 last_torque{0};          // N·m, torque that the hand felt in the last tick
    dvec3 last_spindle_force{0};   // N, force of the spindle in the last tick
    dvec3 last_teeth_force{0};     // N, part of last_spindle_force by the cutting edges
    dvec3 last_sent{0};            // N, total force in the last tick
    dvec3 last_spindle_torque{0};  // N·m, torque of the spindle in the last tick
    double teeth_energy = 0;       // J, energy from the cutting edges to the hand
  };

  /// State of the friction on soft tissue.
  struct SoftContact {
    FrictionState friction;
    dvec3 p{0};  // m, position of the tool in its last contact with soft tissue
  };

  ServoSettings settings;
  std::span<const Tool> tools;  // tools in the settings
  std::vector<double> wear;     // for each tool: its wear so far (see ServoTick::wear)
  std::uint32_t in_hand = 0;
  std::unique_ptr<ContactModel> model;
  const Snapshot* snapshot;  // snapshot of the tissue that the model uses
  double travel;             // m, model's travel(): motion of the tool after which a new snapshot is due
  // turns_matter() of the model; true: rotations change the clearance, so the clearance is computed in every tick
  bool turns_matter;
  Motion motion;
  Cutting cutting;
  Turning turning;
  Coupling coupling;
  Limits limits;
  std::unique_ptr<SoftTissue> soft;  // null: the scene has no soft tissue
  SoftContact soft_contact;
  ServoTick sums;  // running totals: index, removed, energy, spindle_energy, cuts, wear

  explicit State(const ServoSettings& s);
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  const Tool& tool() const noexcept { return tools[in_hand]; }
  /// Speed (rad/s) of the unloaded spindle at full pedal with the tool in the hand.
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
    double specific_energy = 0;  // J/m³, mean specific energy of the tissues, scaled by the hardness
    double energy_ratio = 1;     // energy per volume of the chips divided by the specific energy
    double force_ratio = 0;      // tangential force of the edges divided by their normal force
  };
  EdgeMeans edge_means() const noexcept;

  /// Largest energy deficit that remains after a contact, J; at most PassivityLaw::credit. A larger deficit is cleared:
  /// it would allow no force, and without force the hand could never supply the missing energy.
  double max_deficit() const noexcept { return std::min(LimitParameters::deficit, limits.law.credit); }

  /// Largest energy deficit that is cleared when a contact ends, J. Usually `limits.given`, the energy that the contact
  /// was allowed to return. A deficit above max_deficit() has other causes, such as late ticks, and is cleared
  /// completely.
  double cancelled_deficit() const noexcept { return sums.energy < -max_deficit() ? -sums.energy : limits.given; }

  // The next functions are defined in servo.cpp:
  /// Handles a tick without a valid pose or hand: zero force. The next valid tick starts a new sequence of poses.
  void rest(TickData& now, bool valid) noexcept;
  void begin_anew(const Pose& X_WT, Nanos t) noexcept;
  /// Adds the energy that the device gave to the hand since the last tick to the ledger. Always inlined, because a
  /// called function would have to wait until the hand's pose, which was just written, can be read.
  [[gnu::always_inline]] inline void account(TickData& now, bool turns) noexcept;
  /// Lets the spindle's speed follow the pedal. earn() subtracts what a load takes.
  [[gnu::always_inline]] inline void run_spindle(const TickData& now) noexcept;
  /// Changes to the wanted tool if the spindle stands still, and neither the wanted nor the old tool touches tissue.
  void change_tool(TickData& now) noexcept;
  /// Shortcut for a tool far from all tissue, with the same result as a full tick. Returns false and does nothing if a
  /// contact, a force or a state of a contact may remain.
  [[gnu::always_inline]] inline bool move_free(TickData& now) noexcept;
  void fill_input(ContactTick& now) const noexcept;
  /// Computes the contact; without a snapshot, the proxy stays where it is.
  void find_contact(ContactTick& now) noexcept;
  void watch_snapshot(ContactTick& now) noexcept;
  void watch_start(ContactTick& now) noexcept;
  /// Removes tissue with the energy of this tick. If the tissue changed, returns true and sets the Cut.
  bool remove(ContactTick& now) noexcept;
  void remember(ContactTick& now, const dvec3& felt_torque) noexcept;
  /// Adds the contact with soft tissue to the tick. Called only if the scene has soft tissue.
  void report_soft(ContactTick& now) noexcept;

  // The next functions are defined in servo/cutting.cpp:
  /// Computes the energy for removal in this tick from the last force, J.
  void earn(ContactTick& now) noexcept;
  void spend(ContactTick& now, double energy) noexcept;
  /// Wears the grains of the diamond bur in the hand, by the volume that this tick's cut removed.
  void wear_grains(ContactTick& now) noexcept;

  // The next functions are defined in servo/turn.cpp:
  /// Returns true if the device renders torque and the tool in the hand can feel it.
  bool feels_turns() const noexcept;
  /// Computes the orientation of the proxy in this tick, and where the model begins to search its position.
  void turn(ContactTick& now) noexcept;
  /// Adds the orientation to the contact that the model has computed.
  void hold_turn(ContactTick& now) noexcept;

  // The next functions are defined in servo/coupling.cpp.
  /// For a penalty method: without tissue at the tool, the plane of the last contact replaces the springs.
  void bridge_springs(ContactTick& now) noexcept;
  /// After a plane has replaced the springs: lets their force return at a limited rate.
  void return_springs(ContactTick& now) noexcept;
  /// Computes forces of coupling, damper, friction and cutting edges. A penalty method replaces coupling and damper.
  void feel(ContactTick& now) noexcept;
  /// Lets the tip sink into softened tissue, where it sticks.
  void sink_tip(ContactTick& now) noexcept;
  /// Lets soft tissue yield and push the tool away. Called only if `soft` is set.
  void press_soft(ContactTick& now) noexcept;
  /// Adds the vibration of the spindle.
  void vibrate(ContactTick& now) noexcept;

  // The next functions are defined in servo/limits.cpp:
  /// Limits force, torque and their rates, and applies the ramps.
  void limit(ContactTick& now) noexcept;
  /// Passivity: reduces the force so that the device gives the hand at most the energy that the hand has supplied, plus
  /// a small credit. Returns the torque that the device can render.
  dvec3 keep_passive(ContactTick& now) noexcept;

 private:
  double paid_fraction(const ContactTick& now) noexcept;
  /// Change of the tissue's force and of the cutting edges' force in this tick, N.
  dvec3 force_change(const ContactTick& now) const noexcept;
  /// Returns true if the tool cuts or scrapes. Then more limits apply (limits.cpp): its force on tissue rises softly.
  static bool lands(const ContactTick& now) noexcept;
  double held_back(const ContactTick& now, double change) const noexcept;
  double landing_fraction(const ContactTick& now, double at_stake) const noexcept;
  void press_teeth(const ContactTick& now) noexcept;
  void feel_nothing(ContactTick& now) noexcept;
  void couple(ContactTick& now, double depth) noexcept;
  void take_force(ContactTick& now) noexcept;
  double spare_change(const ContactTick& now, double depth) const noexcept;
  double follow_stiffness(const ContactTick& now, double depth, double strain, double wanted) noexcept;
  int nearest_step(const PoseStep& wanted, double lever, PoseStep& step, ActivePlanesOf<6>& active) noexcept;
  void place(ContactTick& now, const dvec3& wanted, dvec3& r) noexcept;
  void keep_holds(const ActivePlanesOf<6>& active) noexcept;
  void feel_held_tissue(ContactTick& now) noexcept;
  double damped(const ContactTick& now, double push, double depth) noexcept;
  void feel_teeth(ContactTick& now) noexcept;
  void fade_teeth(ContactTick& now) noexcept;
  void limit_teeth_energy(ContactTick& now) noexcept;
};

}  // namespace typodont::haptics
