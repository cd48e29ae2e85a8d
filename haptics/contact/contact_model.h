// The part of a contact method that runs on the servo thread. It computes the poses that the tool may have, the tissue
// that the tool touches, and the tissue that a cut removes.
//
// A method consists of two parts that share no data: a ContactModel on the servo thread and a TissueBody
// (tissue_body.h) on the carver thread. The model sends cuts to the body, and the body sends snapshots of the tissue to
// the model. A ContactMethod (contact_method.h) creates both parts. CONTRIBUTING.md shows how to add a method.
#pragma once

#include <cstdint>

#include "engine/contract/contact.h"
#include "haptics/contact/snapshot.h"

namespace typodont::haptics {

/// Input of a contact model: the state of the hand, and the force of the last tick. SI units; vectors in the workbench
/// frame W.
struct ContactInput {
  Nanos t = 0;             // time of the hand's sample, ns
  std::uint64_t tick = 0;  // index of this tick
  double dt = 1e-3;        // s, time between the last tick and this tick
  Pose X_WT;               // pose that the tool would have if it followed the hand exactly
  Pose X_WG;               // pose of the proxy at the end of the last tick
  dvec3 moved{0};          // m, displacement of the hand since the last tick
  bool jumped = false;     // true: since the last tick, the hand's pose has changed by more than a human hand can move
  double pedal = 0;        // pedal position 0..1; negative: backward rotation, for a tool with a thread

  // The following members describe the contact in the last tick.
  double normal_force = 0;  // N, magnitude of the contact force
  dvec3 normal{0};          // unit normal, pointing out of the tissue
  // factor on ServoSettings::stiffness; its value follows from the tissue under the head
  double relative_stiffness = 1;

  // The following members limit the removal in this tick.
  bool cuts = false;     // true: the tool cuts in this tick, because its spindle rotates or its edge scrapes
  bool scrapes = false;  // true: the tool cuts with an edge that the hand moves over the surface; nothing rotates
  // true: the scraping edge has already removed more tissue than the hand's work has paid for. So it must not remove
  // any tissue in this tick.
  bool must_earn = false;
  double specific_energy = 0;  // J/m³, specific cutting energy of the tissue under the head
  double budget = 0;           // J, energy that may be spent on removing tissue in this tick
  double wall_budget = 0;      // J, part of `budget` that may be spent where a wall of harder tissue stops the head
  double power = 0;            // W, power that the motor delivers at the cutting edges
  double spindle = 0;          // rad/s, speed of the spindle under load
};

/// Result of a contact model. A model with a proxy (constraint method) computes the pose of the proxy. A penalty method
/// computes force, torque and stored energy. Both kinds of model set all other members. SI units; vectors in the
/// workbench frame W. Members with the comment "in `unit`" are lengths that are stated as multiples of the member
/// `unit`.
struct Contact {
  // The following members are results of constrain(). p_WG: m, position of the proxy's head centre; a penalty method
  // has no proxy and states the position at the hand's pose.
  dvec3 p_WG{0};
  bool touching = false;  // the head touches tissue
  // true: the head has just passed through the tissue, and the proxy still moves towards the hand
  bool breaking_through = false;
  bool lost = false;  // true: the tool has left the region of the tissue that the snapshot contains
  bool deep = false;  // true: the head is so deep inside the tissue that the model finds no surface near it
  // true: there is no snapshot of the tissue around the tool, so the plane of the last contact replaces the tissue
  bool bridging = false;
  bool late = false;         // true: the snapshot has been missing for longer than a carver normally needs
  bool rejoining = false;    // true: after a time without a snapshot (`bridging`), the proxy now returns to the surface
  bool leading_out = false;  // true: the proxy overlapped tissue and is now moved out of it
  bool settled = true;       // false: the head touches nothing, but the model still stores data of the last contact
  // true: the servo must call cut() although the tool does not cut, because the model inserts an implant into the
  // tissue, or because it must finish a cut of an earlier tick
  bool places = false;
  // Vector from the head's position at the hand's pose to the position at which the contacts would hold the head if its
  // speed had no limit. Only the direction is used. Zero without contact.
  dvec3 contact_direction{0};
  double area = 0;            // m², area of the head in contact with tissue; 0: none
  bool own_friction = false;  // true: p_WG already includes friction, so the servo must not add friction
  bool gives_force = false;   // true for a penalty method: feel() sets force, torque, stored and depth
  // 0..1; power that the head can use at a wall of harder tissue, divided by the head's full power; 0: there is no such
  // wall
  double wall = 0;
  std::uint32_t faults = 0;  // bits of enum Fault
  std::uint32_t level = 0;   // level of detail, for a method with several levels; 0 is the finest
  // Unit normal of a boundary to another tissue that stops the tool like a wall. The normal points out of the wall.
  // Zero: there is no wall.
  dvec3 side_normal{0};
  // Smallest allowed stiffness of the coupling along side_normal, as a ratio to ServoSettings::stiffness.
  double side_stiffness = 0;
  // true: the tissue also holds the tool's orientation; the proxy then has the orientation R_WG
  bool holds_turn = false;
  // Orientation of the proxy, used only if `holds_turn` is true. The rotation from the hand's orientation to R_WG
  // determines `torque` and `stored`.
  dquat R_WG{1, 0, 0, 0};
  // N·m, torque that the cutting by the rotating spindle exerts on the tool; used only if `holds_turn` is true
  dvec3 spindle_torque{0};

  // The following members are results of feel(). There are `count` contacts. Contact i pushes the tool at the point x_i
  // along the unit vector n_i with the weight w_i (a length). The first `own` contacts belong to the head. The other
  // contacts belong to the shank or to the safe end (a smooth pin at the tool's tip, which does not cut).
  int count = 0, own = 0;
  bool turns_tool = false;  // true if `lever` and `turn` are valid
  double unit = 1;   // m, length by which other members are divided (comment "in `unit`"): 1 m, or the size of a voxel
  dvec3 lever{0};    // mean lever arm of the contacts, Σ w (x - c) / Σ w, in `unit`; c: position of the head's centre
  dvec3 turn{0};     // moment of all contacts, Σ w (x - c) × n, in `unit` squared
  dvec3 on_head{0};  // sum Σ w n over the contacts of the head, in `unit`
  // Sum Σ w n over the contacts of the shank and of the safe end (smooth pin at the tip), in `unit`. on_head + on_shank
  // is the displacement from the hand to the proxy that the contacts cause.
  dvec3 on_shank{0};
  bool known_tissue = false;  // true: `tissue` is valid; false: the servo keeps the fractions of the last tick
  PerTissue tissue{};         // fraction of each tissue below the contacts; the sum is 1
  bool graded = false;        // true: `hardness` is valid; false: every tissue has its full hardness
  PerTissue hardness{};       // 0..1, mean hardness of each tissue below the contacts (dense_tissue.h)

  // The following members are the force of a penalty method, set in feel(); it replaces the force of the coupling. A
  // constraint method that holds the tool's orientation (`holds_turn`) also sets `torque` and `stored`, but in
  // constrain(): they describe the spring between the orientations of hand and proxy.
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

  /// Begins to use the snapshot `fresh`: exchanges its content with that of the snapshot in use, then repeats the cuts
  /// that were made after `fresh` was taken. `removed`: m³, removed volume so far; the function corrects it by the
  /// volumes of undone cuts and of loose pieces.
  virtual void adopt(Snapshot& fresh, PerTissue& removed) noexcept = 0;
  /// Returns the snapshot in use. It is always the same object; its content changes.
  virtual const Snapshot& snapshot() const noexcept = 0;
  /// Returns the distance in m that the tool may move away from the snapshot's centre before the servo needs a new
  /// snapshot. Infinity if a snapshot contains the whole tissue.
  virtual double travel() const noexcept = 0;

  /// Returns the clearance: the distance in m that the proxy may move from X_WG before it can touch tissue; 0 or less
  /// if the distance is unknown. The value stays valid until adopt() is called. If turns_matter() returns true,
  /// rotations change the clearance, so the servo calls this function in every tick.
  virtual double clearance(const Pose& X_WG) noexcept = 0;
  virtual bool turns_matter() const noexcept { return false; }

  /// Discards the state that depends on the last motion. Called at the hand's first pose, and at the first valid pose
  /// after invalid input.
  virtual void begin_anew() noexcept = 0;
  /// Called once when the tool is far from all tissue. The model then discards the state of the last contact.
  virtual void release() noexcept = 0;
  /// Returns true if the user may change to the tool `tool` while the proxy is at X_WG, because neither the present
  /// tool nor the new tool touches anything there. Must not change what later ticks compute: a recording does not
  /// contain refused changes.
  virtual bool may_change_tool(std::uint32_t tool, const Pose& X_WG) noexcept = 0;
  virtual void take_up(std::uint32_t tool) noexcept = 0;

  /// Computes the proxy. Sets those members of `out` that are results of constrain(): the members from p_WG to
  /// spindle_torque.
  virtual void constrain(const ContactInput& in, Contact& out) noexcept = 0;
  /// Removes as much tissue as the energy of this tick allows, or adds a filling. Returns true if the tissue has
  /// changed, and then sets all members of `cut` except its normal. `energy`: J, energy that was used. Called only if
  /// the tool cuts in this tick, if it is a filling instrument, or if Contact::places is true.
  virtual bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept = 0;
  /// Returns true if the volumes of its cuts are estimates, and adopt() counts the measured ones.
  virtual bool estimates_volume() const noexcept { return false; }
  /// Computes the contacts at the position that the head has after the cut. Sets those members of `out` that are
  /// results of feel(): all from `count` on. Called only while the head is in contact.
  virtual void feel(const ContactInput& in, Contact& out) noexcept = 0;
  /// Returns the tissue at a point inside the snapshot; kAir outside.
  virtual Tissue tissue_at(const dvec3& p_W) const noexcept = 0;
};

}  // namespace typodont::haptics
