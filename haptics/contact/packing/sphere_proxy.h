// The proxy follows the hand as far as the spheres allow (S2, pass 1, sec. III B, C).
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "haptics/contact/packing/sphere_tree.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/sphere_passes.h"

namespace typodont::haptics::packing {

class ComputePasses;

struct ProxyOptions {
  double stiffness = 1000;         // N/m, k of S2, eq. 7
  double damping = 0;              // N·s/m, ζ of S2, eq. 7
  double static_friction = 0.2;    // μ_s of S2, eq. 13
  double dynamic_friction = 0.15;  // μ_d of S2, eq. 13, at most μ_s
  // m of the farthest point per follow(); the rest follows
  double longest_path = std::numeric_limits<double>::infinity();
};

struct ProxyContact {
  dvec3 p_W{0};     // m, point of contact
  dvec3 n_W{0};     // from the tissue's to the tool's sphere
  int sphere = -1;  // index of the tissue's sphere
  int tool_sphere = -1;
  double push = 0;  // m, by which this contact holds the proxy along n_W
};

/// Servo thread; follow() is noexcept, never allocates. m, N, W. Tested paths only, so it never passes through a
/// sphere. A contact's plane becomes a constraint, and the proxy goes on to the nearest allowed position: a projection
/// in translation and rotation, by Gauss–Seidel on the multipliers.
class SphereProxy {
 public:
  SphereProxy(const ToolSpheres& tool, const ProxyOptions& options);

  /// Untested. Overlapping spheres can be left, not entered.
  void place(const Pose& X_W) noexcept;
  /// Untested, after a cut along the motion.
  void move_to(const Pose& X_W) noexcept;
  /// S2, eq. 13, by the tissue in contact.
  void set_friction(double static_friction, double dynamic_friction) noexcept {
    options_.static_friction = static_friction, options_.dynamic_friction = dynamic_friction;
  }
  /// If spheres may have grown or come back.
  void forget_near() noexcept;
  /// Per changed sphere. Lists stay valid for one that shrank; a cut over several ticks also moves it, up to
  /// `protrudes` m beyond its surface.
  void note_cut(const SphereTree& tree, Place place, double protrudes) noexcept {
    if (!(protrudes > 0)) return;
    noted_ = true;
    if (protrudes <= kStickOut) {
      protrudes_ = std::max(protrudes_, protrudes);
    } else {
      note_large(tree, place, protrudes);
    }
  }
  /// Per cutting sphere, after its note_cut() calls and before the next search.
  void end_notes() noexcept;

  /// Motion of the non-cutting parts in a cut: `move` (m) and `turn` (rad) become the nearest without penetration,
  /// sliding allowed; keeps contacts. Returns the fraction before a new contact, searched on the first `longest_path`
  /// m; 1: none.
  double non_cutting_parts_allow(const SphereTree& tree, double longest_path, dvec3& move, dvec3& turn) noexcept;
  /// Per tick, as near to the hand as possible. `gpu`, if ready, finds the first contact.
  void follow(const SphereTree& tree, const Pose& X_WH, ComputePasses* gpu = nullptr) noexcept;

  /// Of one tool sphere, to `to`; as SphereTree::near_segment().
  std::size_t near_path(const SphereTree& tree, std::size_t tool_sphere, const Pose& to,
                        std::span<Place> found) const noexcept;

  /// Enlarged by `epsilon` (m), at the proxy; as SphereTree::near_segment().
  std::size_t near_here(const SphereTree& tree, std::size_t tool_sphere, double epsilon,
                        std::span<Place> found) noexcept;

  const ToolSpheres& tool() const { return tool_; }
  const Pose& pose() const { return X_W_; }
  std::span<const ProxyContact> contacts() const { return {contacts_.data(), count_}; }
  bool touches() const { return pushed_ > 0; }
  bool sticks() const { return sticks_; }
  /// Sum of normals by pushes, as unit; zero without contact.
  const dvec3& normal() const { return n_W_; }

  /// S2, eq. 7: N on the hand. `v_WH`: m/s.
  dvec3 force(const dvec3& v_WH) const noexcept;
  /// S2, eq. 8: N·m of `force` at the contact point, about the centre of mass.
  dvec3 torque(const dvec3& force) const noexcept;
  /// m, contacts by pushes.
  dvec3 contact_point() const noexcept;
  dvec3 com() const noexcept { return X_W_ * tool_.com_T; }

  /// rad, rotation vector.
  static dvec3 rotation_angle(const dquat& from, const dquat& to) noexcept;
  static dquat turned_by(const dvec3& turn) noexcept;

  static constexpr std::size_t kMostContacts = 12;
  static constexpr double kGap = 1e-7;  // m kept from a sphere

 private:
  // m of protrusion that reduces all lists' margins; more reduces only those around.
  static constexpr double kStickOut = 1e-6;

  /// From the proxy's pose.
  struct Motion {
    Pose to;
    // m of T's origin; rotation as a chord of the unit circle
    double shift = 0, turn = 0;
    /// m, for a sphere `arm` (m) from T's origin.
    double way(double arm) const { return shift + turn * arm; }
  };
  /// Verlet 1967: tissue spheres near one of the tool, in the tree's order, valid for its margin of motion. One search
  /// in many ticks.
  struct NearList {
    // m; all unlisted ones were at least this far
    double margin = 0;
    // m of the tool sphere since, plus all `protrudes`
    double moved = 0;
    // m, largest protrusion in the present cut
    double protrudes = 0;
    // m to the nearest when listed; negative: overlap
    double free = 0;
    // m, largest `epsilon` of near_here() within the margin; negative: no room, so it searches the tree
    double wider = 0;
    std::size_t count = 0;  // number of spheres in the list
    // searches until a too long list is made again
    int refused = 0;
  };
  /// Not complete yet.
  struct NextList {
    std::size_t tool_sphere = 0;
    bool active = false;
    dvec3 center{0};                // m, of the tool sphere
    double margin = 0;              // m
    double moved = 0;               // m since the start (NearList::moved)
    SphereTree::PartSearch search;  // search for the spheres of the list
    std::size_t leaves = 0;         // leaves so far
    std::size_t expected = 0;       // leaves of the last complete search; 0: none
    std::size_t count = 0;
    std::vector<Place> places;
    std::vector<float> gaps;  // m
  };
  struct Constraint {
    // gap per m of translation, and per rad, m
    dvec3 n{0}, turn{0};
    double gap = 0;  // m, present gap of the contact
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
  /// `way`: m of validity.
  void list_near(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center, double way) noexcept;
  void start_list(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center, double margin) noexcept;
  bool continue_list(const SphereTree& tree, std::size_t leaves) noexcept;
  void use_list() noexcept;
  void prepare_lists(const SphereTree& tree) noexcept;
  double spread_margin(std::size_t tool_sphere, double margin) const noexcept;
  /// visit(place) for gaps up to limit() when listed, and a few more. May reduce limit().
  template <class Limit, class Visit>
  void each_listed(std::size_t tool_sphere, Limit&& limit, Visit&& visit) const noexcept;
  std::size_t listed_near(const SphereTree& tree, std::size_t tool_sphere, double gap, const dvec3& a, const dvec3& b,
                          double reach, std::span<Place> found) const noexcept;
  Motion motion_to(const Pose& goal) const noexcept;
  void note_large(const SphereTree& tree, Place place, double protrudes) noexcept;
  std::size_t contact_of(int tool_sphere, int sphere) const noexcept;
  void add_contact(const SphereTree& tree, int tool_sphere, int sphere) noexcept;

  ToolSpheres tool_;
  ProxyOptions options_;
  double lever_;  // m, rad to lengths in project()
  Pose X_W_, X_WH_;
  std::array<ProxyContact, kMostContacts> contacts_;
  std::array<Constraint, kMostContacts> constraints_;
  std::size_t count_ = 0;
  std::vector<double> arm_;      // m from T's origin, per sphere
  std::vector<NearList> lists_;  // per tool sphere
  std::size_t room_;             // room per list, a multiple of 8
  std::vector<Place> listed_;    // in sequence
  // m when listed; infinite: unused
  std::vector<float> gap_;
  NextList next_;
  std::vector<double> moved_before_;         // m, `moved` at the last tick's end
  std::vector<SweptBall> swept_;             // of a GPU search
  std::vector<std::size_t> sphere_of_ball_;  // tool sphere of each
  // m, largest protrusion since end_notes(), up to kStickOut
  double protrudes_ = 0;
  bool noted_ = false;  // a cut sphere has protruded since end_notes()
  double pushed_ = 0;   // m, all pushes
  dvec3 n_W_{0};
  bool sticks_ = false;
};

}  // namespace typodont::haptics::packing
