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

/// Input of a contact model: the hand, and the force of the last tick. SI, frame W.
struct ContactInput {
  Nanos t = 0;             // time of the hand's sample
  std::uint64_t tick = 0;  // index of this tick
  double dt = 1e-3;        // s, time since the last tick
  Pose X_WT;               // pose of the tool in the hand
  Pose X_WG;               // the proxy at the end of the last tick
  dvec3 moved{0};          // m, displacement of the hand since the last tick
  double pedal = 0;        // 0..1; negative: backwards, for a tool with a thread

  // Contact force of the last tick.
  double normal_force = 0;        // N
  dvec3 normal{0};                // unit normal, pointing out of the tissue
  double relative_stiffness = 1;  // factor on the stiffness in the settings, from the tissue under the head

  // Limits of the removal in this tick.
  bool cuts = false;     // the tool cuts: its spindle turns, or its edge scrapes
  bool scrapes = false;  // the tool cuts with an edge that the hand draws over the surface, without rotation
  // the scraping edge has removed more volume than its work has paid for, so it must not remove more now
  bool must_earn = false;
  double specific_energy = 0;  // J/m³, specific cutting energy of the tissue under the head
  double budget = 0;           // J, energy that may be spent on removal
  double wall_budget = 0;      // J, part of the budget that may be spent on a wall of harder tissue
  double power = 0;            // W, power at the teeth
  double spindle = 0;          // rad/s, speed of the spindle under load
};

/// Result of a contact model. A constraint method fills in the proxy; a penalty method fills in force, torque and
/// stored energy; both fill in the remaining members. SI, frame W, except for members in `unit`.
struct Contact {
  // The members below are results of constrain().
  dvec3 p_WG{0};                  // m, head's centre at the proxy (for a penalty method: at the hand)
  bool touching = false;          // the head touches tissue
  bool breaking_through = false;  // the head has broken through, and the proxy is still on its path to the hand
  bool lost = false;              // the tool is outside the snapshot
  bool deep = false;              // the head is inside the tissue, and no surface is near enough to be found
  bool bridging = false;          // the servo lacks a snapshot of the tissue here; the last contact's plane replaces it
  bool late = false;              // the snapshot has been lacking for longer than a carver normally needs
  bool rejoining = false;         // a snapshot was lacking (bridging); the proxy now returns to the surface
  bool leading_out = false;       // the proxy moves out of tissue that it overlapped
  bool settled = true;            // false: a free head still has state from this contact
  bool places = false;            // the tool stays in the tissue: the servo calls cut() even if the tool does not cut
  // Vector from the hand to the position at which contacts alone hold the head; zero: no contact holds it
  dvec3 contact_direction{0};
  double area = 0;            // m², area of the head that lies on tissue; 0: none
  bool own_friction = false;  // p_WG already lags because of friction, so the servo adds no friction
  bool gives_force = false;   // true for a penalty method: feel() fills in force, torque, stored and depth
  // 0..1, fraction of the power that remains for the head at a wall of harder tissue; 0: no wall holds the head
  double wall = 0;
  std::uint32_t faults = 0;  // bits of enum Fault
  std::uint32_t level = 0;   // level of detail, for a method with several; 0: the finest
  // unit, normal of a wall between tissues that holds the tool from the side, out of the wall; zero: no wall
  dvec3 side_normal{0};
  // Stiffness along side_normal, relative to the settings; the coupling becomes at least this stiff there
  double side_stiffness = 0;
  bool holds_turn = false;  // the tissue also holds the tool's orientation: X_WG turns to R_WG
  // Orientation of the proxy, if `holds_turn`; the rotation from the hand to the proxy determines `torque` and `stored`
  dquat R_WG{1, 0, 0, 0};
  dvec3 spindle_torque{0};  // N·m, torque on the tool from the work of its spindle; only if `holds_turn`

  // Results of feel(). Contact i pushes along n_i at x_i with the weight w_i. There are `count` contacts: the first
  // `own` belong to the head, the others to the shank or the safe end.
  int count = 0, own = 0;
  bool turns_tool = false;  // `lever` and `turn` are valid
  double unit = 1;          // m, length unit of `lever` and `turn`
  dvec3 lever{0};           // Σ w (x - c) / Σ w, in `unit`; c: centre of the head
  dvec3 turn{0};            // Σ w (x - c) × n, in `unit`
  dvec3 on_head{0};         // Σ w n over the head's contacts, in `unit`
  // Σ w n over the contacts of shank and safe end, in `unit`; added to `on_head`: the proxy's depth
  dvec3 on_shank{0};
  bool known_tissue = false;  // `tissue` is valid; otherwise the last value stays in use
  PerTissue tissue{};         // fraction of each tissue under the contacts; sum 1
  bool graded = false;        // `hardness` is valid; otherwise every tissue has its own hardness
  PerTissue hardness{};       // mean hardness of each tissue under the contacts, 0..1 (hardness.h)

  // Results of feel() of a penalty method; the servo then adds no coupling. For a method that holds the tool's
  // orientation, constrain() sets `torque` and `stored` to the values of the orientation spring.
  dvec3 force{0};     // N, force on the tool, including the damper
  dvec3 torque{0};    // N·m, torque on the tool about the head's centre
  double stored = 0;  // J, energy stored in the method's springs
  double depth = 0;   // m, the deepest penetration
};

/// Servo thread only. All functions are noexcept; none allocates, locks or waits. Equal inputs and equal snapshots give
/// equal bits. In a tick the servo calls constrain(), cut(), feel(), in this order.
class ContactModel {
 public:
  virtual ~ContactModel() = default;

  /// Adopts the content of `fresh` and adds the cuts made since it was taken; `fresh` receives the old buffers.
  /// `removed`: m³ so far, corrected by undone cuts and loose pieces.
  virtual void adopt(Snapshot& fresh, PerTissue& removed) noexcept = 0;
  /// The snapshot in use. During the model's life this is always the same object; its content changes.
  virtual const Snapshot& snapshot() const noexcept = 0;
  /// Distance that the tool may move from the snapshot's centre before the servo needs a new snapshot, m; infinity if
  /// a snapshot contains all of the tissue.
  virtual double travel() const noexcept = 0;

  /// Clearance: the distance that the proxy at X_WG may move before it can touch anything, m; 0 or less if unknown.
  /// The value stays valid until adopt(). Exception: if turns_matter() is true, the servo queries it in every tick.
  virtual double clearance(const Pose& X_WG) noexcept = 0;
  virtual bool turns_matter() const noexcept { return false; }

  /// Called when the hand appears, or returns after illegal input. The tool is then at the proxy.
  virtual void begin_anew() noexcept = 0;
  /// Called once when the tool is far from all tissue: the model drops the state of the last contact.
  virtual void release() noexcept = 0;
  /// Returns true if the tool in the hand may be replaced by `tool` at the proxy, because neither touches anything.
  virtual bool may_change_tool(std::uint32_t tool, const Pose& X_WG) noexcept = 0;
  virtual void take_up(std::uint32_t tool) noexcept = 0;

  /// Computes the proxy. Fills in the first part of `out`.
  virtual void constrain(const ContactInput& in, Contact& out) noexcept = 0;
  /// Removes the tissue that this tick's energy pays for, or adds a filling. If tissue changed, returns true and fills
  /// in `cut`, except for its normal. `energy`: J used. Not called in a tick in which the tool neither cuts nor fills.
  virtual bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept = 0;
  /// Computes the contacts at the head's new position, after the cut. Fills in the second part of `out`. Called only
  /// while the tissue holds the tool back.
  virtual void feel(const ContactInput& in, Contact& out) noexcept = 0;
  /// The tissue at a point within the snapshot; air outside.
  virtual Tissue tissue_at(const dvec3& p_W) const noexcept = 0;
};

}  // namespace typodont::haptics
