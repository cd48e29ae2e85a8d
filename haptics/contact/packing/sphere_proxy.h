// The proxy follows the hand as far as the spheres of the tissue allow (paper S2 in docs/papers.md, III B and C).
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "haptics/contact/packing/sphere_tree.h"
#include "haptics/contact/packing/tool_spheres.h"

namespace typodont::haptics::packing {

/// rad, largest rotation per step; treating its arc as a chord then errs by at most 5e-5 of the tool's reach.
inline constexpr double kMaxTurn = 0.02;

struct ProxyOptions {
  double static_friction = 0.2;    // coefficient μ_s of S2, eq. 13
  double dynamic_friction = 0.15;  // coefficient μ_d of S2, eq. 13, at most μ_s
  // m, largest path of the tool's farthest point per call of follow()
  double longest_path = std::numeric_limits<double>::infinity();
};

struct ProxyContact {
  dvec3 p_W{0};     // m, point of contact
  dvec3 n_W{0};     // unit vector from the tissue's sphere to the tool's sphere
  int sphere = -1;  // index of the tissue's sphere
  int tool_sphere = -1;
  double push = 0;  // m, displacement of the proxy along n_W by this contact
};

/// Servo thread only; never allocates. SI units. The proxy moves only along tested paths, so it never passes through a
/// sphere. Each contact limits the proxy by a plane; a projection in translation and rotation (Gauss–Seidel) gives the
/// allowed pose nearest to the hand.
class SphereProxy {
 public:
  SphereProxy(const ToolSpheres& tool, const ProxyOptions& options);

  /// Sets the pose without a collision test. From an overlap with tissue, the tool can move out, but not deeper.
  void place(const Pose& X_W) noexcept;
  /// Sets the pose after a cut, without a collision test.
  void move_to(const Pose& X_W) noexcept;
  /// Sets the friction coefficients of the tissue (paper S2, eq. 13).
  void set_friction(double static_friction, double dynamic_friction) noexcept {
    options_.static_friction = static_friction, options_.dynamic_friction = dynamic_friction;
  }
  /// Discards the lists of near spheres. Call it if tissue spheres may have grown or returned.
  void forget_near() noexcept;
  /// Call it for each changed sphere. The lists of near spheres remain valid if spheres only become smaller. But a cut
  /// may also move a sphere, which then extends up to `protrudes` m beyond its surface before the cut.
  void note_cut(const SphereTree& tree, Place place, double protrudes) noexcept {
    if (!(protrudes > 0)) return;
    noted_ = true;
    if (protrudes <= kStickOut) {
      protrudes_ = std::max(protrudes_, protrudes);
    } else {
      note_large(tree, place, protrudes);
    }
  }
  /// Must be called once per tool sphere: after the last note_cut() for this sphere, and before the next search.
  void end_notes() noexcept;

  /// Limits the motion of the non-cutting parts in a cut: `move` (m) and `turn` (rad) become the nearest motion without
  /// penetration. Returns the fraction of this motion up to the next contact within `longest_path` m; 1: no contact.
  double non_cutting_parts_allow(const SphereTree& tree, double longest_path, dvec3& move, dvec3& turn) noexcept;
  /// Moves the proxy as near to the hand as possible; once per tick.
  void follow(const SphereTree& tree, const Pose& X_WH) noexcept;

  /// Lists the tissue spheres that one tool sphere can touch on its path to `to`, like SphereTree::near_segment().
  std::size_t near_path(const SphereTree& tree, std::size_t tool_sphere, const Pose& to,
                        std::span<Place> found) const noexcept;

  /// Lists the tissue spheres within `epsilon` (m) of one tool sphere at the proxy's pose (SphereTree::near_segment()).
  std::size_t near_here(const SphereTree& tree, std::size_t tool_sphere, double epsilon,
                        std::span<Place> found) noexcept;

  const ToolSpheres& tool() const { return tool_; }
  const Pose& pose() const { return X_W_; }
  std::span<const ProxyContact> contacts() const { return {contacts_.data(), count_}; }
  bool touches() const { return pushed_ > 0; }

  /// Mean of the contact points, m, weighted by the pushes of the contacts.
  dvec3 contact_point() const noexcept;

  /// Rotation vector between two orientations, rad.
  static dvec3 rotation_angle(const dquat& from, const dquat& to) noexcept;
  static dquat turned_by(const dvec3& turn) noexcept;

  static constexpr std::size_t kMaxContacts = 12;
  static constexpr double kGap = 1e-7;  // m, distance that the proxy keeps from a sphere

 private:
  // m; if a cut sphere protrudes by at most this, all near lists lose margin; otherwise only the lists around it
  static constexpr double kStickOut = 1e-6;

  /// A motion from the current pose of the proxy.
  struct Motion {
    Pose to;
    // shift: m, motion of the origin of frame T. turn: chord of the rotation's angle on the unit circle, without unit.
    double shift = 0, turn = 0;
    /// Upper bound of the motion of a sphere that is `arm` (m) from the origin of frame T, m.
    double travel(double arm) const { return shift + turn * arm; }
  };
  /// Tissue spheres near one tool sphere, in the tree's order (Verlet 1967). The list is valid while the tool sphere
  /// moves by less than the margin, usually for many ticks.
  struct NearList {
    // m; when the list was made, all spheres outside it were at least this far from the tool sphere
    double margin = 0;
    // m, motion of the tool sphere since its list was made, plus the protrusions of cut tissue spheres
    double moved = 0;
    // m, largest distance by which this cut moved a part of a tissue sphere outside the sphere's old surface
    double protrudes = 0;
    // m, distance of the nearest tissue sphere when the list was made; negative: overlap
    double free = 0;
    // m, largest `epsilon` of near_here() for which the list is complete; negative: the tree must be searched
    double wider = 0;
    std::size_t count = 0;  // number of spheres in the list
    // number of coming searches for which no list is made, because the last list was too long
    int refused = 0;
  };
  /// A list of near spheres that is still being made.
  struct NextList {
    std::size_t tool_sphere = 0;
    bool active = false;
    dvec3 center{0};                // m, centre of the tool sphere when the list was begun
    double margin = 0;              // m, motion of the tool sphere for which the list will be valid
    double moved = 0;               // m, motion since the list was begun (NearList::moved)
    SphereTree::PartSearch search;  // search for the spheres of the list
    std::size_t leaves = 0;         // number of leaves searched so far
    std::size_t expected = 0;       // number of leaves of the last complete search; 0: none
    std::size_t count = 0;
    std::vector<Place> places;
    std::vector<float> gaps;  // m, gap of each sphere in the list
  };
  /// Earliest contact; at equal times, the one with the lowest `ball`, then the lowest `sphere`.
  struct FirstContact {
    double t = kNever;  // fraction 0..1 of the path; kNever: no contact
    // Indices of the tool sphere and the tissue sphere; -1: no contact.
    int ball = -1, sphere = -1;
  };
  struct Constraint {
    // change of the gap per m of translation (no unit), and per rad of rotation (m)
    dvec3 n{0}, turn{0};
    double gap = 0;  // m, current gap between the two spheres of the contact
    double multiplier = 0;
  };
  void project(const dvec3& move, const dvec3& turn, dvec3& allowed_move, dvec3& allowed_turn,
               std::size_t first_sphere = 0) noexcept;
  SphereTree::Hit first_listed(const SphereTree& tree, std::size_t tool_sphere, const Motion& motion, double until,
                               bool& certain) noexcept;
  FirstContact first_contact(const SphereTree& tree, std::size_t first_sphere, const Pose& goal) noexcept;
  double reached(const SphereTree& tree, const Pose& goal, const FirstContact& first) const noexcept;
  /// `travel`: m, motion of the tool sphere for which the list must be valid.
  void list_near(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center, double travel) noexcept;
  void start_list(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center, double margin) noexcept;
  bool continue_list(const SphereTree& tree, std::size_t leaves) noexcept;
  void use_list() noexcept;
  void prepare_lists(const SphereTree& tree) noexcept;
  double spread_margin(std::size_t tool_sphere, double margin) const noexcept;
  /// Calls visit(places) for the spheres of a list whose gap was at most limit() when the list was made, and for a few
  /// more, at most eight at a time. visit() may reduce limit().
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
  double lever_;  // m, converts rotations to lengths in project()
  Pose X_W_;
  std::array<ProxyContact, kMaxContacts> contacts_;
  std::array<Constraint, kMaxContacts> constraints_;
  std::size_t count_ = 0;
  std::vector<double> arm_;      // m, each tool sphere's distance from the origin of T
  std::vector<NearList> lists_;  // for each tool sphere: its near list
  std::size_t list_capacity_;    // capacity of each near list in spheres, a multiple of 8
  std::vector<Place> listed_;    // spheres of all lists, one list after another
  // m, gap between each listed sphere and its tool sphere when the list was made; infinity: the slot is unused
  std::vector<float> gap_;
  NextList next_;
  std::vector<double> moved_before_;   // m, for each list: `moved` at the end of the last tick
  std::vector<std::size_t> unlisted_;  // tool spheres whose lists are too short for the current motion
  // m, largest distance of at most kStickOut by which a cut sphere protruded from its old surface since end_notes()
  double protrudes_ = 0;
  bool noted_ = false;  // true: since end_notes(), a cut sphere has protruded from its old surface
  double pushed_ = 0;   // m, sum of the pushes of all contacts
  bool sticks_ = false;
};

}  // namespace typodont::haptics::packing
