// What a servo carries from tick to tick, step by step: Motion, Cutting, Coupling, Limits, and the contact model.
// Servo::tick in servo.cpp calls the steps in turn.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "haptics/contact_model.h"
#include "haptics/coupling/friction.h"
#include "haptics/coupling/passivity.h"
#include "haptics/coupling/tip.h"
#include "haptics/coupling/velocity_estimator.h"
#include "haptics/servo.h"
#include "haptics/servo/parameters.h"

namespace typodont::haptics {

/// The tick that is being computed: what every tick has. SI, frame W.
struct TickData {
  const HandSample& hand;  // as it came in
  ServoTick& out;
  Cut& cut;
  Pose X_WT{};               // of the hand, checked, unit quaternion
  double dt = 0;             // s since the last tick, as measured
  dvec3 moved{0};            // m, the hand since the last tick
  dvec3 turned{0};           // rad, its turn
  double given_to_hand = 0;  // J since the last tick
};

/// The tick of a tool that may touch something.
struct ContactTick : TickData {
  explicit ContactTick(const TickData& tick) noexcept : TickData(tick) {}

  ContactInput in;
  Contact contact;
  std::uint32_t faults = 0;
  SpindleLoad spindle{};
  double tangential = 0;  // force of the teeth over normal force
  dvec3 force{0}, torque{0}, normal{0};
  dvec3 spindle_force{0};   // N that the spindle feeds to the hand: teeth and vibration
  dvec3 teeth_force{0};     // N, the teeth's part of it
  dvec3 spindle_torque{0};  // N·m that the spindle feeds to the hand
  dvec3 p_held{0};          // m, where the tool is held
  double stored = 0;        // J in the coupling
};

/// The passivity law of a servo with these settings. A scene that is larger, with a coupling softer by as much, has the
/// same forces: what the law foresees of a hand and gives it is larger by as much, up to the limit of a nanojoule. The
/// hand of a device is a human hand whatever the scene, and its jumps are counts of the encoders.
PassivityLaw law_for(const ServoSettings& settings);

/// Every tissue is as hard as its material says.
inline PerTissue own_hardness() noexcept {
  PerTissue all;
  all.fill(1);
  return all;
}

struct Servo::State {
  /// Hand and proxy.
  struct Motion {
    Pose X_WG;             // the proxy: where the tool is held outside the tissue
    bool placed = false;   // X_WG is valid
    bool started = false;  // there was a tick before
    Nanos began = 0;       // when the hand came, or came back
    Nanos last_t = 0;
    Pose last_hand;
    dquat came_R{0, 0, 0, 0}, R_WT{1, 0, 0, 0};  // the hand's orientation as it last came in, and that as a unit
    double leap = 0;                             // s left to follow a leap of the input
    double due_for = 0;                          // s that a new snapshot has been due
    bool idle = false;                           // the last tick left nothing of a contact
    bool released = false;                       // the model knows that
    double room = 0;                             // m that a free tool may still move before the model is asked again
  };
  /// The spindle, and the energy that may be spent on removal.
  struct Cutting {
    double speed = 0;         // rad/s, running free
    double phase = 0;         // rad
    double budget = 0;        // J; negative: removed in advance
    double wall = 0;          // a wall held the head in the last tick: fraction of the power that it leaves; 0: none
    double wall_budget = 0;   // J, the part of it that may be spent on that wall
    double spindle_work = 0;  // J done in cutting so far
  };
  /// What the contact gives the hand.
  struct Coupling {
    double relative_stiffness = 1;        // of the tissue under the head, over the settings' coupling
    PerTissue tissue{};                   // fractions of it
    PerTissue hardness = own_hardness();  // mean hardness of each of its tissues, 0..1 (hardness.h)
    double normal_force = 0;              // N, last tick
    double head_force = 0;                // N, the part of it that lies on the head
    dvec3 normal{0};
    dvec3 pressed{0};     // unit, the direction in which contacts and debt push the head
    double pressing = 0;  // N, the component of head_force along it
    FrictionState friction;
    TipState tip;
    double rate = 0;                // m/s of the depth, smoothed
    VelocityEstimator depth_speed;  // the same where the hand moves by counts, whose differences would buzz
    double last_depth = 0;          // m
    dvec3 torque{0};                // N·m, before the limits
    dvec3 teeth_force{0};           // N, before the limits
    explicit Coupling(double position_step) : depth_speed(position_step, 1) {}
  };
  /// What was sent, and the ledger.
  struct Limits {
    PassivityLaw law;
    PassivityState passivity;
    double stored = 0;    // J in the coupling, last tick
    double given = 0;     // J that leading the tool out of tissue put into the coupling: allowed for
    bool unpaid = false;  // the ledger holds far less than the coupling: the force follows the ledger
    double ramp = 0;      // 0..1, of the force at start and end
    bool ending = false;
    dvec3 last_force{0};           // N, by the tissue
    dvec3 last_torque{0};          // N·m, as felt
    dvec3 last_spindle_force{0};   // N, by the spindle
    dvec3 last_teeth_force{0};     // N, the teeth's part of it
    dvec3 last_sent{0};            // N, all of it
    dvec3 last_spindle_torque{0};  // N·m
    double teeth_energy = 0;       // J that the teeth gave the hand so far
  };

  ServoSettings settings;
  std::span<const Tool> tools;  // of the settings
  std::uint32_t in_hand = 0;
  std::unique_ptr<ContactModel> model;
  const Snapshot* snapshot;  // the model's
  double travel;             // m, the model's
  bool turns_matter;         // the model's, of the tool in the hand
  Motion motion;
  Cutting cutting;
  Coupling coupling;
  Limits limits;
  ServoTick sums;  // carries index, removed, energy, cuts

  explicit State(const ServoSettings& s);
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  const Tool& tool() const noexcept { return tools[in_hand]; }
  /// rad/s at full pedal, of the tool in the hand.
  double free_speed() const noexcept { return tool().free_speed(settings.spindle.free_speed); }
  /// Mean of a material's property over the tissue under the head.
  double mean(double Material::*member) const noexcept;
  /// The same of a property that hardness scales: stiffness or specific energy.
  double mean_hardened(double Material::*member) const noexcept;

  /// J of ledger debt that is not forgiven: never more than the law gives credit for. A greater one would allow no
  /// force, without a force nothing is ever paid, and the servo would stay silent for good.
  double most_debt() const noexcept {
    return settings.laws < 2 ? LimitParameters::debt : std::min(LimitParameters::debt, limits.law.credit);
  }

  // servo.cpp
  /// A tick without a valid pose or without a hand: no force, and the next tick begins anew.
  void rest(TickData& now, bool valid) noexcept;
  void begin_anew(const Pose& X_WT, Nanos t) noexcept;
  /// The ledger: what the device did to the hand since the last tick. Always inlined: the hand's pose was written just
  /// before, and a function call would read it back from memory in other pieces, which waits for the store.
  [[gnu::always_inline]] inline void account(TickData& now, bool turns) noexcept;
  /// Takes up the tool that the hand wants if neither that tool nor the one in the hand touches or turns.
  void change_tool(TickData& now) noexcept;
  /// The rest of a tick of a tool that is far from everything, and was before: the same result as the long way if no
  /// contact, force or state of one is left. False, and nothing done, where there may be more to it.
  bool fly(TickData& now) noexcept;
  void fill_input(ContactTick& now) const noexcept;
  void watch_snapshot(ContactTick& now) noexcept;
  /// Removes what this tick pays for. True and a Cut where tissue changed.
  bool remove(ContactTick& now) noexcept;
  void remember(ContactTick& now, const dvec3& felt_torque) noexcept;

  // servo/cutting.cpp
  /// The spindle's free speed follows the pedal.
  void run_spindle(const TickData& now) noexcept;
  /// The energy that may be spent on removal in this tick, from the push of the last.
  void earn(ContactTick& now) noexcept;
  void spend(ContactTick& now, double energy) noexcept;

  // servo/coupling.cpp
  /// Coupling, damper, friction and teeth; of a penalty method its own force, friction and teeth.
  void feel(ContactTick& now) noexcept;
  /// A sharp tip in softened tissue: sinks under a push, holds on withdrawal.
  void sink_tip(ContactTick& now) noexcept;
  /// What the spindle sends through the arm.
  void vibrate(ContactTick& now) noexcept;

  // servo/limits.cpp
  /// Limits of the device, of its slew, and the ramps at start and end.
  void limit(ContactTick& now) noexcept;
  /// Never gives the hand energy that it did not put in: the controller, and the ledger's allowances. Returns the part
  /// of the torque that the hand's arm can give.
  dvec3 keep_passive(ContactTick& now) noexcept;

 private:
  double paid_fraction(const ContactTick& now) noexcept;
  void feel_nothing(ContactTick& now) noexcept;
  void couple(ContactTick& now, double depth) noexcept;
  void take_force(ContactTick& now) noexcept;
  double spare_change(const ContactTick& now, double depth) const noexcept;
  double follow_stiffness(const ContactTick& now, double depth) noexcept;
  double damped(const ContactTick& now, double push, double depth) noexcept;
  void feel_teeth(ContactTick& now) noexcept;
  void fade_teeth(ContactTick& now) noexcept;
  void keep_teeth_paid(ContactTick& now) noexcept;
};

}  // namespace typodont::haptics
