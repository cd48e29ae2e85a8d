// The tool's proxy among spheres: it follows the hand as far as no sphere is in the way. S2, pass 1 and sec. III B, C.
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
};

struct ProxyContact {
  dvec3 p_W{0};     // m, where the spheres touch
  dvec3 n_W{0};     // unit, from the tissue's sphere to the tool's
  int sphere = -1;  // of the tissue
  int tool_sphere = -1;
  double push = 0;  // m, how far the constraint holds the proxy back along n_W
};

/// Servo thread. follow() is noexcept and never allocates. Frame W, metres, newtons.
///
/// The proxy only moves along ways that were swept free, so it cannot pass through a sphere at any speed. Where it is
/// stopped, the plane of the contact becomes a constraint, and it goes on to the place nearest to the hand that all
/// constraints allow (a projection in translation and rotation, by Gauss–Seidel on the constraints' multipliers).
class SphereProxy {
 public:
  SphereProxy(const ToolSpheres& tool, const ProxyOptions& options);

  /// Puts the proxy there, whatever lies there. Spheres that overlap it let it out, but no deeper.
  void place(const Pose& X_W) noexcept;
  /// Moves it without looking, where a cut has just made room.
  void move_to(const Pose& X_W) noexcept;
  /// μ_s and μ_d of eq. 13 from now on: of the tissue that is touched.
  void set_friction(double static_friction, double dynamic_friction) noexcept {
    options_.static_friction = static_friction, options_.dynamic_friction = dynamic_friction;
  }
  /// Spheres may have grown or come back: the lists of near spheres are no longer right.
  void forget_near() noexcept;
  /// A cut has made this of a sphere. A cut sphere lies within the sphere that the cut began with, but it may stick out
  /// of what an earlier tick of the same cut had left of it.
  void note_cut(const SphereTree& tree, int sphere, const dvec3& center_before, double radius_before) noexcept;

  /// Of a cut: the way nearest to `move` and `turn` (m, rad) on which the parts that never cut stay out of what they
  /// touch, and how much of it they can go, 0 to 1. Lists the contacts along which they go. What lies beyond `most_way`
  /// (m) is not looked at: 1 then.
  double smooth_parts_allow(const SphereTree& tree, double most_way, dvec3& move, dvec3& turn) noexcept;
  /// One tick: as near to the hand as the spheres allow. `gpu` looks for the first contact where it is given and ready.
  void follow(const SphereTree& tree, const Pose& X_WH, ComputePasses* gpu = nullptr) noexcept;

  /// As SphereTree::near_segment(), of the way of one of the tool's spheres from the proxy's pose to another one.
  std::size_t near_way(const SphereTree& tree, std::size_t tool_sphere, const Pose& to,
                       std::span<int> found) const noexcept;

  const ToolSpheres& tool() const { return tool_; }
  const Pose& pose() const { return X_W_; }
  std::span<const ProxyContact> contacts() const { return {contacts_.data(), count_}; }
  bool touches() const { return pushed_ > 0; }
  bool sticks() const { return sticks_; }
  /// Unit, the sum of the contacts' normals by their push; zero where nothing is touched.
  const dvec3& normal() const { return n_W_; }

  /// Eq. 7: on the hand, N; v_WH in m/s.
  dvec3 force(const dvec3& v_WH) const noexcept;
  /// Eq. 8: about the tool's centre of mass, N m, for that force.
  dvec3 torque(const dvec3& force) const noexcept;
  /// Where that force acts: the contacts' places by their push; m.
  dvec3 contact_point() const noexcept;
  dvec3 com() const noexcept { return X_W_ * tool_.com_T; }

  /// What stands between two poses: a rotation vector, rad.
  static dvec3 turn_between(const dquat& from, const dquat& to) noexcept;
  static dquat turned_by(const dvec3& turn) noexcept;

  static constexpr std::size_t kMostContacts = 12;
  static constexpr double kGap = 1e-7;  // m that is left between proxy and sphere

 private:
  /// From the proxy's pose to another one.
  struct Motion {
    Pose to;
    double shift = 0, turn = 0;  // m of the frame's origin; rad, as a chord of the unit circle
    /// A bound of how far the tool's sphere at this distance from the frame's origin moves, m.
    double way(double arm) const { return shift + turn * arm; }
  };
  /// The tissue's spheres near one of the tool's, nearest first. It serves until the tool's sphere has moved by the
  /// list's margin (a Verlet list, Verlet 1967): in a cavity the tree is asked once for many ticks.
  struct NearList {
    double margin = 0;  // m: a sphere that is not in the list was at least this far away
    double moved = 0;   // m, bound of how far the tool's sphere has moved since
    double free = 0;    // m, how far away the nearest sphere was; negative where it overlaps
    std::size_t count = 0;
    int refused = 0;  // searches until the list is tried again: it did not fit
  };
  struct Near {
    double gap;  // m
    int sphere;
  };
  struct Constraint {
    dvec3 n{0}, turn{0};  // per metre of translation along it, and per metre of rotation × lever
    double gap = 0;       // m
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
  void list_near(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center) noexcept;
  Motion motion_to(const Pose& goal) const noexcept;
  std::size_t contact_of(int tool_sphere, int sphere) const noexcept;
  void add_contact(const SphereTree& tree, int tool_sphere, int sphere) noexcept;

  ToolSpheres tool_;
  ProxyOptions options_;
  double lever_;  // m, by which rotations count as ways
  Pose X_W_, X_WH_;
  std::array<ProxyContact, kMostContacts> contacts_;
  std::array<Constraint, kMostContacts> constraints_;
  std::size_t count_ = 0;
  std::vector<double> arm_;         // m, of the tool's spheres from the frame's origin
  std::vector<NearList> lists_;     // of each of the tool's spheres …
  std::size_t room_;                // … how many spheres each has room for …
  std::vector<Near> near_;          // … and these, list by list
  std::vector<int> found_;          // of one search …
  std::vector<Near> found_gaps_;    // … and how far away they are
  std::vector<SweptBall> swept_;    // of one look on the GPU …
  std::vector<std::size_t> asked_;  // … and which of the tool's spheres each is
  double pushed_ = 0;               // m, sum of the pushes
  dvec3 n_W_{0};
  bool sticks_ = false;
};

}  // namespace typodont::haptics::packing
