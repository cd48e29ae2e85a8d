// The part of a contact method that runs on the servo thread. It computes the poses that the tool may have, the tissue
// that the tool touches, and the tissue that a cut removes.
//
// A method consists of two parts that share no data: a ContactModel on the servo thread and a TissueBody
// (tissue_body.h) on the carver thread. Cuts go from the model to the body, snapshots from the body to the model. A
// ContactMethod (contact_method.h) makes both. CONTRIBUTING.md shows how to add one.
#pragma once

#include <cstdint>

#include "engine/contract/contact.h"
#include "haptics/snapshot.h"

namespace typodont::haptics {

/// Input of a contact model: the state of the hand, and the force of the last tick. SI, frame W.
struct ContactInput {
  Nanos t = 0;             // time of the hand's sample, ns
  std::uint64_t tick = 0;  // index of this tick
  double dt = 1e-3;        // s, time since the last tick
  Pose X_WT;               // pose of the tool if it follows the hand exactly
  Pose X_WG;               // pose of the proxy at the end of the last tick
  dvec3 moved{0};          // m, displacement of the hand since the last tick
  bool jumped = false;     // true: the hand's pose has jumped, farther than a human hand can move in a tick
  double pedal = 0;        // pedal position 0..1; negative: backward rotation, for a tool with a thread

  // The following members describe the contact in the last tick.
  double normal_force = 0;        // N, magnitude of the contact force
  dvec3 normal{0};                // unit normal, pointing out of the tissue
  double relative_stiffness = 1;  // factor on ServoSettings::stiffness; it depends on the tissue under the head

  // The following members limit the removal in this tick.
  bool cuts = false;     // the tool cuts in this tick: its spindle rotates, or its edge scrapes
  bool scrapes = false;  // the tool cuts with an edge that the hand draws over the surface without rotation
  // true: the scraping edge has removed more than corresponds to its work, so it must not remove anything in this
  // tick
  bool must_earn = false;
  double specific_energy = 0;  // J/m³, specific cutting energy of the tissue under the head
  double budget = 0;           // J, energy that may be spent on removing tissue in this tick
  double wall_budget = 0;      // J, the part of `budget` that may be spent at a wall of harder tissue
  double power = 0;            // W, power that the motor delivers at the cutting edges
  double spindle = 0;          // rad/s, speed of the spindle under load
};

/// Result of a contact model. A model with a proxy (constraint method) sets the pose of the proxy. A penalty method
/// sets force, torque and stored energy. Both kinds of model set the remaining members. SI, frame W; lengths with the
/// comment "in `unit`" are multiples of the member `unit`.
struct Contact {
  // The following members are results of constrain().
  dvec3 p_WG{0};                  // m, position of the head's centre at the proxy; for a penalty method, at the hand
  bool touching = false;          // the head touches tissue
  bool breaking_through = false;  // the head has broken through the tissue, and the proxy still moves towards the hand
  bool lost = false;              // the tool is outside the region that the snapshot contains
  bool deep = false;              // the head is so deep inside the tissue that no surface is found
  // there is no snapshot of the tissue at the tool; the plane of the last contact replaces the tissue
  bool bridging = false;
  bool late = false;         // true: the snapshot has been missing for longer than a carver normally needs
  bool rejoining = false;    // a snapshot was missing (bridging), and the proxy now returns to the surface
  bool leading_out = false;  // the proxy is moved out of tissue that it overlapped
  bool settled = true;       // false: the head is free, but the model still has state from the last contact
  // true: the servo calls cut() although the tool does not cut, because it must insert an implant into the tissue, or
  // because a cut of earlier ticks is not finished
  bool places = false;
  // Vector from the hand to where the contacts would hold the head without a limit of its speed; zero without contact.
  dvec3 contact_direction{0};
  double area = 0;            // m², area of the head in contact with tissue; 0: none
  bool own_friction = false;  // p_WG already includes the effect of friction, so the servo must not add friction
  bool gives_force = false;   // true for a penalty method: feel() sets force, torque, stored and depth
  // Ratio 0..1 of the power at a wall of harder tissue to the head's full power; 0: there is no such wall.
  double wall = 0;
  std::uint32_t faults = 0;  // bits of enum Fault
  std::uint32_t level = 0;   // level of detail, for a method with several levels; 0 is the finest
  // Unit normal of a wall between tissues that stops the tool, pointing out of the wall; zero: no wall.
  dvec3 side_normal{0};
  // Smallest stiffness of the coupling along side_normal, as a ratio to the stiffness in ServoSettings.
  double side_stiffness = 0;
  bool holds_turn = false;  // true: the tissue also constrains the tool's orientation, to R_WG
  // Orientation of the proxy, if `holds_turn`. The rotation from the hand to the proxy determines `torque` and
  // `stored`.
  dquat R_WG{1, 0, 0, 0};
  dvec3 spindle_torque{0};  // N·m, torque that the spindle's work causes on the tool; used only if `holds_turn`

  // The following members are results of feel(). Contact i pushes the tool along the unit vector n_i at the point x_i
  // with the weight w_i. There are `count` contacts: the first `own` contacts belong to the head, the others to the
  // shank or the safe (not cutting) end.
  int count = 0, own = 0;
  bool turns_tool = false;  // true if `lever` and `turn` are valid
  double unit = 1;          // m, unit of length of `lever` and `turn`
  dvec3 lever{0};           // mean lever arm of the contacts, Σ w (x - c) / Σ w, in `unit`; c: centre of the head
  dvec3 turn{0};            // sum of torques Σ w (x - c) × n, in `unit`
  dvec3 on_head{0};         // sum Σ w n over the contacts of the head, in `unit`
  // Sum Σ w n over the contacts of the shank and the safe (not cutting) end, in `unit`. The sum of on_head and on_shank
  // is the displacement by which the contacts keep the proxy away from the hand.
  dvec3 on_shank{0};
  bool known_tissue = false;  // true if `tissue` is valid; otherwise the servo keeps the last value
  PerTissue tissue{};         // fraction of each tissue under the contacts; the sum is 1
  bool graded = false;        // true if `hardness` is valid; otherwise every tissue has its full hardness
  PerTissue hardness{};       // mean hardness of each tissue under the contacts, 0..1 (hardness.h)

  // The following members are results of feel() of a penalty method. The servo then adds no coupling. A method that
  // constrains the tool's orientation sets `torque` and `stored` in constrain(), to the values of its orientation
  // spring.
  dvec3 force{0};     // N, force on the tool, including the damper's force
  dvec3 torque{0};    // N·m, torque on the tool about the head's centre
  double stored = 0;  // J, energy stored in the springs of the method
  double depth = 0;   // m, largest penetration depth
};

/// The part of a contact method on the servo thread. All functions are noexcept; none allocates, locks or waits. The
/// results are deterministic. In a tick the servo calls constrain(), cut() and feel(), in this order.
class ContactModel {
 public:
  virtual ~ContactModel() = default;

  /// Exchanges the content of the snapshot in use with that of `fresh`, and repeats the cuts that were made after
  /// `fresh` was taken. `removed`: removed volume so far, m³; the function corrects it for undone cuts and loose
  /// pieces.
  virtual void adopt(Snapshot& fresh, PerTissue& removed) noexcept = 0;
  /// Returns the snapshot in use. It is always the same object; its content changes.
  virtual const Snapshot& snapshot() const noexcept = 0;
  /// Returns the distance in m that the tool may move from the centre of the snapshot before the servo needs a new one.
  /// Infinity if a snapshot contains the whole tissue.
  virtual double travel() const noexcept = 0;

  /// Returns the clearance: the distance in m that the proxy at X_WG may move before it can touch anything; 0 or less
  /// if unknown. The value stays valid until adopt(). If turns_matter() returns true, the servo asks for it again in
  /// every tick.
  virtual double clearance(const Pose& X_WG) noexcept = 0;
  virtual bool turns_matter() const noexcept { return false; }

  /// Discards the state of the last motion. Called for the hand's first pose, and for a valid pose after invalid input.
  virtual void begin_anew() noexcept = 0;
  /// Called once when the tool is far from all tissue. The model then discards the state of the last contact.
  virtual void release() noexcept = 0;
  /// Returns true if the tool may be replaced by `tool` at the proxy, because neither of them touches anything.
  virtual bool may_change_tool(std::uint32_t tool, const Pose& X_WG) noexcept = 0;
  virtual void take_up(std::uint32_t tool) noexcept = 0;

  /// Computes the proxy. Sets those members of `out` that are results of constrain(): all from p_WG on.
  virtual void constrain(const ContactInput& in, Contact& out) noexcept = 0;
  /// Removes as much tissue as the energy of this tick allows, or adds a filling. If the tissue has changed, returns
  /// true and sets `cut` except for its normal. `energy`: used energy, J. Not called if the tool neither cuts nor fills
  /// in this tick.
  virtual bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept = 0;
  /// Computes the contacts at the head's new position, after the cut. Sets those members of `out` that are results of
  /// feel(): all from `count` on. Called only while the head is in contact.
  virtual void feel(const ContactInput& in, Contact& out) noexcept = 0;
  /// Returns the tissue at a point inside the snapshot; kAir outside.
  virtual Tissue tissue_at(const dvec3& p_W) const noexcept = 0;
};

}  // namespace typodont::haptics
