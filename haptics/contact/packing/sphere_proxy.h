// The tool's proxy among spheres: it follows the hand as far as the spheres allow. Paper S2, pass 1 and sec. III B,
// C.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "haptics/contact/packing/sphere_tree.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/sphere_passes.h"

namespace typodont::haptics::packing {

class ComputePasses;

struct ProxyOptions {
  double stiffness = 1000;         // N/m, k of eq. 7
  double damping = 0;              // N s/m, ζ of eq. 7
  double static_friction = 0.2;    // μ_s of eq. 13
  double dynamic_friction = 0.15;  // μ_d, at most μ_s
  // The projection onto the constraints begins with the last multipliers, which needs fewer iterations; false: with
  // zero, as in the force laws before version 7.
  bool starts_from_last = true;
};

struct ProxyContact {
  dvec3 p_W{0};     // m, point of contact
  dvec3 n_W{0};     // unit vector from the tissue's sphere to the tool's sphere
  int sphere = -1;  // index of the tissue's sphere
  int tool_sphere = -1;
  double push = 0;  // m, distance by which the constraint holds the proxy back along n_W
};

/// Servo thread. follow() is noexcept and never allocates. Frame W, metres, newtons.
/// The proxy moves only along swept, collision-free paths, so it cannot pass through a sphere at any speed. If a
/// contact stops it, the contact's plane becomes a constraint, and the proxy continues to the position nearest to the
/// hand that satisfies all constraints (a projection in translation and rotation, by Gauss–Seidel on the constraints'
/// multipliers).
class SphereProxy {
 public:
  SphereProxy(const ToolSpheres& tool, const ProxyOptions& options);

  /// Sets the proxy's pose without collision test. Spheres that overlap the tool let it move out but not deeper.
  void place(const Pose& X_W) noexcept;
  /// Moves the proxy without collision test, after a cut has removed the tissue on the motion.
  void move_to(const Pose& X_W) noexcept;
  /// Sets μ_s and μ_d of eq. 13, which depend on the tissue in contact.
  void set_friction(double static_friction, double dynamic_friction) noexcept {
    options_.static_friction = static_friction, options_.dynamic_friction = dynamic_friction;
  }
  /// Invalidates the near lists, because spheres may have grown or returned.
  void forget_near() noexcept;
  /// Must be called when a cut changed a sphere. A cut sphere lies within the sphere before that cut, but it may
  /// protrude from its state after an earlier tick of the same cut.
  void note_cut(const SphereTree& tree, int sphere, const dvec3& center_before, double radius_before) noexcept;
  /// Must be called after the note_cut() of the spheres that one of the tool's spheres changed, before the next search.
  void end_notes() noexcept;

  /// For a cut: changes `move` and `turn` (m, rad) to the nearest motion on which the non-cutting parts do not
  /// penetrate the tissue; they may slide along it. Lists these contacts. Returns the fraction 0 to 1 of that motion
  /// that is possible before a new contact. If the motion is longer than `longest_path` (m), contacts are not searched,
  /// and the fraction is 1.
  double non_cutting_parts_allow(const SphereTree& tree, double longest_path, dvec3& move, dvec3& turn) noexcept;
  /// One tick: moves the proxy as near to the hand as the spheres allow. `gpu` searches the first contact, if it is
  /// given and ready.
  void follow(const SphereTree& tree, const Pose& X_WH, ComputePasses* gpu = nullptr) noexcept;

  /// Result of SphereTree::near_segment() for the motion of one of the tool's spheres, from the proxy's pose to
  /// another pose.
  std::size_t near_path(const SphereTree& tree, std::size_t tool_sphere, const Pose& to,
                        std::span<int> found) const noexcept;

  /// Result of SphereTree::near_segment() for one of the tool's spheres at the proxy's pose, enlarged by `epsilon` (m).
  std::size_t near_here(const SphereTree& tree, std::size_t tool_sphere, double epsilon, std::span<int> found) noexcept;

  const ToolSpheres& tool() const { return tool_; }
  const Pose& pose() const { return X_W_; }
  std::span<const ProxyContact> contacts() const { return {contacts_.data(), count_}; }
  bool touches() const { return pushed_ > 0; }
  bool sticks() const { return sticks_; }
  /// Unit vector, the sum of the contacts' normals weighted by their push; zero without contact.
  const dvec3& normal() const { return n_W_; }

  /// Eq. 7: force on the hand, N; v_WH in m/s.
  dvec3 force(const dvec3& v_WH) const noexcept;
  /// Torque of this force about the tool's centre of mass, N m (eq. 8).
  dvec3 torque(const dvec3& force) const noexcept;
  /// Point at which the force acts: the mean of the contacts' positions, weighted by their push; m.
  dvec3 contact_point() const noexcept;
  dvec3 com() const noexcept { return X_W_ * tool_.com_T; }

  /// The rotation from one orientation to the other as a rotation vector, rad.
  static dvec3 rotation_angle(const dquat& from, const dquat& to) noexcept;
  static dquat turned_by(const dvec3& turn) noexcept;

  static constexpr std::size_t kMostContacts = 12;
  static constexpr double kGap = 1e-7;  // m, gap left between proxy and sphere

 private:
  /// Motion from the proxy's pose to another pose.
  struct Motion {
    Pose to;
    double shift = 0, turn = 0;  // m, displacement of the frame's origin; rotation as a chord of the unit circle
    /// Upper bound in m of the displacement of a tool sphere at this distance from the frame's origin.
    double way(double arm) const { return shift + turn * arm; }
  };
  /// The tissue's spheres near one of the tool's spheres, in the tree's order. The list is valid until the tool's
  /// sphere has moved by the list's margin (a Verlet list, Verlet 1967). So in a cavity the tree is searched only once
  /// in many ticks.
  struct NearList {
    double margin = 0;  // m: when the list was made, all spheres outside the list were at least this far away
    // m, upper bound of the displacement of the tool's sphere since the list was made, and of the distances by which
    // the tissue's spheres have protruded since then
    double moved = 0;
    double protrudes = 0;  // m, largest protrusion that end_notes() adds to `moved`
    double free = 0;       // m, distance of the nearest sphere; negative if it overlaps
    double wider = 0;      // m, part of the margin for near_here(); negative: the list has no room for it
    std::size_t count = 0;
    int refused = 0;  // number of searches that remain until the list is tried again, because it was too long
  };
  struct Constraint {
    // n: change of the gap per metre of translation along each axis. turn: m, change of the gap per radian of
    // rotation
    dvec3 n{0}, turn{0};
    double gap = 0;  // m
    double multiplier = 0;
  };
  void project(const dvec3& move, const dvec3& turn, dvec3& allowed_move, dvec3& allowed_turn,
               std::size_t first_sphere = 0) noexcept;
  FirstContact first_contact(const SphereTree& tree, const Pose& goal, ComputePasses* gpu) noexcept;
  SphereTree::Hit first_listed(const SphereTree& tree, std::size_t tool_sphere, const Motion& motion, double until,
                               bool& certain) noexcept;
  FirstContact first_of_tool(const SphereTree& tree, std::size_t begin, std::size_t end, const Motion& motion,
                             double until) noexcept;
  double reached(const SphereTree& tree, const Pose& goal, const FirstContact& first) const noexcept;
  /// `way`: m, upper bound of the motion for which the list is made.
  void list_near(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center, double way) noexcept;
  /// Calls visit(sphere) for the listed spheres whose gap was at most limit(), which the visits may reduce, and for a
  /// few others.
  template <class Limit, class Visit>
  void each_listed(std::size_t tool_sphere, Limit&& limit, Visit&& visit) const noexcept;
  std::size_t listed_near(const SphereTree& tree, std::size_t tool_sphere, double gap, const dvec3& a, const dvec3& b,
                          double reach, std::span<int> found) const noexcept;
  Motion motion_to(const Pose& goal) const noexcept;
  std::size_t contact_of(int tool_sphere, int sphere) const noexcept;
  void add_contact(const SphereTree& tree, int tool_sphere, int sphere) noexcept;

  ToolSpheres tool_;
  ProxyOptions options_;
  double lever_;  // m, lever that converts rotations to lengths
  Pose X_W_, X_WH_;
  std::array<ProxyContact, kMostContacts> contacts_;
  std::array<Constraint, kMostContacts> constraints_;
  std::size_t count_ = 0;
  std::vector<double> arm_;                  // m, distance of each of the tool's spheres from the frame's origin
  std::vector<NearList> lists_;              // lists, one for each of the tool's spheres
  std::size_t room_;                         // number of entries that each list can hold, a multiple of 8
  std::vector<int> listed_;                  // entries of all lists, one list after the other
  std::vector<float> gap_;                   // m, for each entry: gap when the list was made; infinite after the last
  std::vector<int> found_;                   // result of one search
  std::vector<double> found_gaps_;           // m, distances of the found spheres
  std::vector<double> sorted_gaps_;          // m, the same distances, partly sorted
  std::vector<SweptBall> swept_;             // balls of one search on the GPU
  std::vector<std::size_t> sphere_of_ball_;  // for each ball in swept_: index of the tool's sphere
  double protrudes_ = 0;                     // m, largest small protrusion since end_notes()
  bool noted_ = false;                       // a sphere has protruded since end_notes()
  double pushed_ = 0;                        // m, sum of the pushes
  dvec3 n_W_{0};
  bool sticks_ = false;
};

}  // namespace typodont::haptics::packing
