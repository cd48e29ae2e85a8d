// One published method of contact, as the servo sees it: where the tool may be, what it touches there, what a cut
// takes.
//
// A method consists of two halves that share no data: a ContactModel on the servo thread and a TissueBody
// (tissue_body.h) on the carver thread. Cuts go from the model to the body, snapshots from the body to the model. A
// ContactMethod (contact_method.h) makes both. CONTRIBUTING.md shows how to add one.
#pragma once

#include <cstdint>

#include "engine/contract/contact.h"
#include "haptics/snapshot.h"

namespace typodont::haptics {

/// The hand and the last tick's push, as a contact model needs them. SI, frame W.
struct ContactInput {
  Nanos t = 0;             // of the hand's sample
  std::uint64_t tick = 0;  // index of this tick
  double dt = 1e-3;        // s since the last tick
  Pose X_WT;               // the tool where the hand holds it
  Pose X_WG;               // the proxy at the end of the last tick
  dvec3 moved{0};          // m, the hand since the last tick
  double pedal = 0;        // 0..1

  // What the last tick pushed with.
  double normal_force = 0;        // N
  dvec3 normal{0};                // unit, out of the tissue
  double relative_stiffness = 1;  // stiffness of the coupling under the head, over that of the settings

  // What this tick may remove.
  bool cuts = false;           // the tool cuts: its spindle turns, or its edge scrapes
  bool scrapes = false;        // an edge that the hand draws
  bool must_earn = false;      // that edge has removed more than it has earned
  double specific_energy = 0;  // J/m³ of the tissue under the head
  double budget = 0;           // J that may be spent on removal
  double wall_budget = 0;      // J, the part of it that may be spent on a wall of harder tissue
  double power = 0;            // W at the teeth
  double spindle = 0;          // rad/s
};

/// What the head does in the tissue. A constraint method fills in the proxy, a penalty method force, torque and stored
/// energy; both the rest. SI, frame W, but for what is counted in `unit`.
struct Contact {
  // From constrain().
  dvec3 p_WG{0};                  // m, the proxy's head centre (of a penalty method: the hand's)
  bool touching = false;          // the head touches tissue
  bool breaking_through = false;  // the head came free, and the proxy still has to catch up with the hand
  bool lost = false;              // the snapshot does not reach as far as the tool
  bool deep = false;              // the head lies inside the tissue, with no surface in reach
  bool bridging = false;          // the last contact's plane stands in for the missing snapshot
  bool late = false;              // that snapshot has been missing for longer than any carver needs
  bool rejoining = false;         // the proxy finds back to the surface after that
  bool leading_out = false;       // the proxy is led out of tissue that it overlapped
  bool settled = true;            // nothing of this contact goes on if the head is free
  bool places = false;            // the tool stays in the tissue: cut() is called, whether or not the tool cuts
  dvec3 held_off_direction{0};    // from the hand to where contacts alone hold the head; zero where they do not
  double area = 0;                // m² of the head that lies on tissue; 0 where none
  bool own_friction = false;      // p_WG lags by friction already: the servo adds none
  bool gives_force = false;       // of a penalty method: force, torque, stored and depth come from feel()
  double wall = 0;            // a wall of harder tissue holds the head: fraction of the power that it leaves; 0: none
  std::uint32_t faults = 0;   // Fault bits
  std::uint32_t level = 0;    // of detail, of a method that has several; 0: the finest
  dvec3 side_normal{0};       // unit, out of a wall between tissues that holds the tool from the side; zero: none
  double side_stiffness = 0;  // along it, over that of the settings; the coupling is never softer than without
  bool holds_turn = false;    // the tissue holds the tool's orientation, too: X_WG turns to R_WG, …
  dquat R_WG{1, 0, 0, 0};     // … and the hand feels `torque` and `stored` for the rest of the way
  dvec3 spindle_torque{0};    // N·m on the tool, by the work of its spindle; only where `holds_turn` is set

  // From feel(). Each contact i pushes with the weight w_i along n_i at x_i, out of `count`, of which the first `own`
  // are the head's and the others the shank's or the safe end's.
  int count = 0, own = 0;
  bool turns_tool = false;    // lever and turn are filled in
  double unit = 1;            // m, of lever and turn
  dvec3 lever{0};             // Σ w (x - c) / Σ w, in `unit`
  dvec3 turn{0};              // Σ w (x - c) × n, weights as the proxy's depth in `unit`
  dvec3 on_head{0};           // Σ w n of the head's own contacts
  dvec3 on_smooth{0};         // Σ w n of the others
  bool known_tissue = false;  // `tissue` is filled in; else the last one still holds
  PerTissue tissue{};         // fractions of the tissue under the contacts; sum 1
  bool graded = false;        // `hardness` is filled in; else every tissue has its own hardness
  PerTissue hardness{};       // mean hardness of each of these tissues, 0..1 (hardness.h)

  // From feel(), of a penalty method: the servo adds no coupling of its own. Of a method that holds the tool's
  // orientation: torque and energy of the spring that does, from constrain().
  dvec3 force{0};     // N on the tool, damper included
  dvec3 torque{0};    // N·m on the tool about the head's centre
  double stored = 0;  // J in its springs
  double depth = 0;   // m, the deepest penetration
};

/// Servo thread only. All functions are noexcept; none allocates, locks or waits. Equal inputs and equal snapshots give
/// equal bits. In a tick the servo calls constrain(), cut(), feel(), in this order.
class ContactModel {
 public:
  virtual ~ContactModel() = default;

  /// Takes the content of `fresh`, brings it up to date with the cuts made since it was taken, and leaves the old
  /// buffers in it. `removed`, m³ so far, is corrected by what undo brought back and what came loose.
  virtual void adopt(Snapshot& fresh, PerTissue& removed) noexcept = 0;
  /// The snapshot that it works in: the same object, with changing content, as long as the model lives.
  virtual const Snapshot& snapshot() const noexcept = 0;
  /// m that the tool may move away from the snapshot's centre before the servo needs another one; infinity where a
  /// snapshot holds all of the tissue.
  virtual double travel() const noexcept = 0;

  /// m that the proxy at X_WG may move before it can touch anything; 0 or less where that is not known. What was free
  /// stays free until adopt(), unless `turns_matter()`: then the servo asks in every tick.
  virtual double clearance(const Pose& X_WG) noexcept = 0;
  virtual bool turns_matter() const noexcept { return false; }

  /// The hand came, or came back after illegal input, and holds the tool at the proxy.
  virtual void begin_anew() noexcept = 0;
  /// The tool is far from all tissue: forgets the last contact. Called once per free flight.
  virtual void release() noexcept = 0;
  /// Whether the tool in the hand may be exchanged for `tool` where the proxy is: neither touches anything.
  virtual bool may_take_up(std::uint32_t tool, const Pose& X_WG) noexcept = 0;
  virtual void take_up(std::uint32_t tool) noexcept = 0;

  /// Where the tool is held. Fills in the first part of `out`.
  virtual void constrain(const ContactInput& in, Contact& out) noexcept = 0;
  /// Removes what the energy of this tick pays for, or adds a filling. True, and `cut` filled in but for its normal,
  /// where any tissue changed. `energy`: J that this took. Not called in a tick in which the tool neither cuts nor
  /// fills.
  virtual bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept = 0;
  /// What the head touches at its new place, after the cut. Fills in the second part of `out`. Called only while the
  /// tissue holds the tool back.
  virtual void feel(const ContactInput& in, Contact& out) noexcept = 0;
  /// The tissue at a point, as far as the snapshot reaches; air elsewhere.
  virtual Tissue tissue_at(const dvec3& p_W) const noexcept = 0;
};

}  // namespace typodont::haptics
