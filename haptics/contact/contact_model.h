// The servo's part of a contact method: poses that the tool may have, and the tissue that it touches and removes. It
// shares no data with the carver's part, TissueBody (tissue_body.h). CONTRIBUTING.md shows how to add a method.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "engine/contract/contact.h"
#include "haptics/contact/snapshot.h"

namespace typodont::haptics {

/// Contact in the last tick. SI units, frame W.
struct LastContact {
  double normal_force = 0;  // N, magnitude of the contact force
  dvec3 normal{0};          // unit normal of the tissue in contact, pointing out of the tissue
  // factor on ServoSettings::stiffness; its value follows from the tissue under the head
  double relative_stiffness = 1;
};

/// Limits of the removal of tissue in one tick.
struct RemovalLimits {
  double pedal = 0;      // pedal position 0..1; negative: a tool with a thread turns backward
  bool cuts = false;     // true: the tool cuts in this tick, because its spindle rotates or its edge scrapes
  bool scrapes = false;  // true: the tool cuts with an edge that the hand moves over the surface; nothing rotates
  // true: earlier cuts of the scraping edge used more energy than the hand's work supplied, so it must not cut now
  bool must_earn = false;
  double specific_energy = 0;  // J/m³, specific cutting energy of the tissue under the head
  double budget = 0;           // J, energy for removing tissue in this tick
  double wall_budget = 0;      // J, part of `budget` that may be used where a wall of harder tissue stops the head
  double power = 0;            // W, power that the motor delivers at the cutting edges
  double spindle = 0;          // rad/s, speed of the spindle under load
};

/// Input of a contact model in one tick: the state of the hand, and results of the last tick. SI units; vectors in the
/// workbench frame W.
struct ContactInput {
  double dt = 1e-3;     // s, time between the last tick and this tick
  Pose X_WT;            // pose of the tool if it followed the hand exactly
  Pose X_WG;            // pose of the proxy after the last tick
  dvec3 moved{0};       // m, displacement of the hand since the last tick
  bool jumped = false;  // true: since the last tick, the hand has moved faster than a human hand can
  // true: X_WT is not the hand's pose, but that of the proxy, computed from near_planes(). The model takes it, unless
  // the tool overlaps tissue there.
  bool placed = false;
  LastContact last;
  RemovalLimits removal;
};

/// Whether the servo lacks a snapshot of the tissue at the tool, and what it does meanwhile. A penalty method sets only
/// `lost`; the servo does the rest.
struct SnapshotGap {
  bool lost = false;  // true: the tool has left the servo's snapshot
  // true: there is no snapshot of the tissue around the tool, so the plane of the last contact replaces the tissue
  bool bridging = false;
  bool late = false;       // true: a new snapshot is overdue for longer than a carver normally needs
  bool rejoining = false;  // true: after a time without a snapshot (`bridging`), the proxy now returns to the surface
};

/// A boundary to harder tissue that stops the tool like a wall.
struct HardWall {
  double share = 0;  // 0..1; fraction of the motor's power that the head uses at the wall; 0: no wall
  dvec3 normal{0};   // unit normal, points out of the harder tissue. Zero: none
  // Smallest allowed stiffness of the coupling (spring between hand and proxy) in the direction of `normal`, divided by
  // ServoSettings::stiffness.
  double stiffness = 0;
};

/// Orientation of the proxy, if the tissue also holds the tool's orientation.
struct HeldOrientation {
  bool held = false;  // true: the proxy has the orientation R_WG; false: it has the hand's orientation
  dquat R_WG{1, 0, 0, 0};
  dvec3 spindle_torque{0};  // N·m, torque that the cutting by the rotating spindle exerts on the tool; only if `held`
};

/// Springs of a contact method. In a penalty method, they give the whole force, in place of the coupling. In another
/// method, `torque` and `stored` belong to the spring between the orientations of hand and proxy (HeldOrientation).
struct ContactSprings {
  bool whole = false;  // true: these springs give the whole force (penalty method)
  dvec3 force{0};      // N, force on the tool, including the damper's force
  dvec3 torque{0};     // N·m, torque on the tool about the head's centre
  double stored = 0;   // J, stored energy
  double depth = 0;    // m, largest penetration depth of the head in tissue
};

/// Result of ContactModel::constrain(). A constraint method computes the pose of the proxy; a penalty method computes
/// force, torque and stored energy. SI units; vectors in the workbench frame W.
struct Contact {
  // m, the proxy's head centre. Initially the head's centre at the hand's pose; a penalty method keeps this value.
  dvec3 p_WG{0};
  bool touching = false;  // the head touches tissue
  // true: the head has just broken through the tissue, and the proxy still moves towards the hand
  bool breaking_through = false;
  bool deep = false;         // true: the head is so deep inside the tissue that the model finds no surface near it
  bool leading_out = false;  // true: the proxy overlapped tissue and is being moved out
  bool settled = true;       // false: the head touches nothing, but the model still stores data of the last contact
  // true: the servo must call cut() although the tool does not cut: the model inserts an implant, or must finish an
  // earlier cut
  bool places = false;
  bool own_friction = false;  // true: p_WG includes friction, so the servo adds none
  // Direction from the head's centre at the hand's pose to the position at which the contacts would hold the head
  // without a speed limit. Only the direction is used. Zero without contact.
  dvec3 contact_direction{0};
  double area = 0;           // m², contact area of the head; 0: none
  std::uint32_t faults = 0;  // bits of enum Fault
  std::uint32_t level = 0;   // level of detail, for methods with several; 0: finest
  SnapshotGap gap;
  HardWall wall;
  HeldOrientation orientation;
  ContactSprings spring;
};

/// Result of ContactModel::feel(). Contact i pushes the tool at point x_i along the unit vector n_i with weight w_i (a
/// length). The first `own` contacts belong to the head, the others to the shank or the safe end. SI units; vectors in
/// the workbench frame W. "in `unit`": a multiple of the member `unit`.
struct Felt {
  int count = 0, own = 0;
  bool turns_tool = false;  // true if `lever` and `turn` are valid
  double unit = 1;   // m, length by which other members are divided (comment "in `unit`"): 1 m, or the size of a voxel
  dvec3 lever{0};    // mean lever arm of the contacts, Σ w_i (x_i - c) / Σ w_i, in `unit`; c: the head's centre
  dvec3 turn{0};     // moment of all contacts, Σ w_i (x_i - c) × n_i, in `unit` squared
  dvec3 on_head{0};  // Σ w_i n_i (weight × direction) over the head's contacts, in `unit`
  // Σ w_i n_i (weight × direction) over the contacts of the shank and of the safe (non-cutting) end, in `unit`. The
  // contacts displace the proxy from the hand by on_head + on_shank.
  dvec3 on_shank{0};
  bool known_tissue = false;  // true: `tissue` is valid; false: the servo keeps `tissue` of the last tick
  PerTissue tissue{};         // fraction of each tissue below the contacts; the sum is 1
  bool graded = false;        // true: `hardness` is valid; false: full hardness of every tissue
  PerTissue hardness{};       // 0..1, mean hardness of each tissue below the contacts (dense_tissue.h)

  /// Adds a contact to the sums. `weight` and `arm` (position relative to the head's centre) are in `unit`; `lever`
  /// becomes valid when it is divided by the sum of all weights.
  void add(double weight, const dvec3& arm, const dvec3& n, bool on_own_head) noexcept {
    if (turns_tool) {
      lever += weight * arm;
      turn += weight * glm::cross(arm, n);
    }
    (on_own_head ? on_head : on_shank) += weight * n;
  }
  /// Computes `tissue` and `hardness` from sums in these members: weights, and weights × hardness if `has_hardness`.
  /// `total`: sum of all weights of tissue.
  void average(double total, bool has_hardness) noexcept {
    known_tissue = true;
    graded = has_hardness;
    for (std::size_t t = 1; t < tissue.size(); ++t) {
      if (graded) hardness[t] = tissue[t] > 0 ? hardness[t] / tissue[t] : 1;
      tissue[t] /= total;
    }
  }
};

/// Tissue near a point of the tool. A small motion of the tool, which moves the point by d, must satisfy n·d >= -gap.
struct NearPlane {
  dvec3 x{0};        // m, point of the tissue, relative to the head's centre p_WG, frame W
  dvec3 n{0, 0, 1};  // unit normal, pointing out of the tissue
  double gap = 0;    // m, distance between tool and tissue; negative: overlap
};
/// Largest number of planes that a model gives.
inline constexpr int kMaxNearPlanes = 264;

/// The part of a contact method on the servo thread. All functions are noexcept; none allocates, locks or waits. The
/// results are deterministic. In a tick the servo calls constrain(), cut() and feel(), in this order. Before the first
/// snapshot it calls none of these, nor clearance() or is_free().
class ContactModel {
 public:
  virtual ~ContactModel() = default;

  /// Makes `fresh` the snapshot in use, by exchanging contents, and repeats the servo's cuts that `fresh` lacks.
  /// `removed`: m³, volume removed by all cuts; corrected here by the volumes of undone cuts and of loose pieces.
  virtual void adopt(Snapshot& fresh, PerTissue& removed) noexcept = 0;
  /// Snapshot in use. Always the same object; adopt() changes its content.
  virtual const Snapshot& snapshot() const noexcept = 0;
  /// Distance in m that the tool may move away from the snapshot's centre before the servo needs a new snapshot.
  /// Infinity if a snapshot contains the whole tissue.
  virtual double travel() const noexcept { return std::numeric_limits<double>::infinity(); }

  /// Distance in m that the proxy may move from the pose X_WG before it can touch tissue; 0 or less: unknown. Valid
  /// until adopt() is called; if turns_matter() is true, only for the orientation of X_WG.
  virtual double clearance(const Pose& X_WG) noexcept = 0;
  virtual bool turns_matter() const noexcept { return false; }

  /// Discards the state that depends on the last motion. Called at the hand's first pose, and at the first valid pose
  /// after invalid input.
  virtual void begin_anew() noexcept {}
  /// Called once when the tool is far from all tissue: the model discards the state of the last contact.
  virtual void release() noexcept {}
  /// Returns true if the tool with the index `tool` touches nothing at X_WG. Called for the tool in the hand, without
  /// contact force, and for the tool that the user wants to take up. Must not change what later ticks compute, because
  /// a recording does not contain refused changes.
  virtual bool is_free(std::uint32_t tool, const Pose& X_WG) noexcept = 0;
  /// The user has changed to the tool with the index `tool`.
  virtual void take_up(std::uint32_t tool) noexcept = 0;

  /// Computes the proxy, or the force of a penalty method.
  virtual void constrain(const ContactInput& in, Contact& out) noexcept = 0;
  /// Writes the planes near the proxy after the last constrain(), at most kMaxNearPlanes, of head, shank and safe end.
  /// Returns their number. With them, the servo holds the proxy's orientation (servo/turn.cpp); without, it is the
  /// hand's. Called only for a tool that feels torque, and does not cut.
  virtual int near_planes(std::span<NearPlane, kMaxNearPlanes> /*planes*/) const noexcept { return 0; }
  /// Computes plane `i` of near_planes() exactly. Returns true if planes have changed.
  virtual bool refine_near_plane(int /*i*/) noexcept { return false; }
  /// Removes tissue with the energy of this tick, or adds filling. If tissue changed, returns true and sets poses,
  /// volumes and fill_radius of `cut`; the servo sets index, tick and time, and presets tool and spindle. `energy`: J,
  /// energy used. Called only if the tool cuts or fills, or if Contact::places is true.
  virtual bool cut(const ContactInput& /*in*/, Contact& /*contact*/, Cut& /*cut*/, double& /*energy*/) noexcept {
    return false;
  }
  /// Returns true if the volumes of cuts are estimates, which adopt() replaces by measured volumes.
  virtual bool estimates_volume() const noexcept { return false; }
  /// Computes the contacts of the head at its position after the cut. May change the contact's orientation. Called only
  /// while the head is in contact.
  virtual void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept = 0;
  /// Tissue at a point inside the snapshot; kAir outside.
  virtual Tissue tissue_at(const dvec3& p_W) const noexcept = 0;
};

}  // namespace typodont::haptics
