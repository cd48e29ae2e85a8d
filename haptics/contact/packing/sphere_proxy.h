// Moves the tool's proxy among the tissue's spheres. The proxy follows the hand as far as the spheres allow (paper S2,
// pass 1 and sec. III B, C).
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
  double stiffness = 1000;         // N/m, stiffness k of eq. 7 in paper S2
  double damping = 0;              // N·s/m, damping ζ of eq. 7 in paper S2
  double static_friction = 0.2;    // friction coefficient μ_s of eq. 13 in paper S2
  double dynamic_friction = 0.15;  // friction coefficient μ_d of eq. 13 in paper S2, at most μ_s
  // m, largest displacement of the tool's farthest point in one follow(); a longer motion continues in the next call
  double longest_path = std::numeric_limits<double>::infinity();
};

struct ProxyContact {
  dvec3 p_W{0};     // m, point of contact
  dvec3 n_W{0};     // unit vector from the tissue's sphere to the tool's sphere
  int sphere = -1;  // index of the tissue's sphere
  int tool_sphere = -1;
  double push = 0;  // m, push: distance by which this contact holds the proxy back along n_W
};

/// The proxy of a tool that consists of spheres. Servo thread only. follow() is noexcept and never allocates. Units:
/// metres and newtons; vectors in the workbench frame W. The proxy moves only along paths that were tested for
/// collisions, so it cannot pass through a sphere at any speed. If a contact stops the proxy, the plane of this contact
/// becomes a constraint. The proxy then continues to the position nearest to the hand that satisfies all constraints.
/// This is a projection in translation and rotation, solved by Gauss–Seidel iterations on the multipliers of the
/// constraints.
class SphereProxy {
 public:
  SphereProxy(const ToolSpheres& tool, const ProxyOptions& options);

  /// Sets the pose of the proxy without a collision test. If the tool then overlaps spheres, it can move out of them
  /// but not deeper.
  void place(const Pose& X_W) noexcept;
  /// Moves the proxy to the pose `X_W` without a collision test. Called after a cut has removed the tissue on this
  /// motion.
  void move_to(const Pose& X_W) noexcept;
  /// Sets the friction coefficients μ_s and μ_d (paper S2, eq. 13), which depend on the tissue in contact.
  void set_friction(double static_friction, double dynamic_friction) noexcept {
    options_.static_friction = static_friction, options_.dynamic_friction = dynamic_friction;
  }
  /// Discards the near lists (tissue spheres near each tool sphere). Needed when tissue spheres may have become larger,
  /// or when removed ones may have come back.
  void forget_near() noexcept;
  /// Must be called for each tissue sphere that a cut changed. The near lists (tissue spheres near each tool sphere)
  /// remain valid for a sphere that only shrank. But a cut that takes several ticks also moves the sphere. Its new
  /// surface may then lie up to `protrudes` metres outside its previous surface.
  void note_cut(const SphereTree& tree, Place place, double protrudes) noexcept {
    if (!(protrudes > 0)) return;
    noted_ = true;
    if (protrudes <= kStickOut) {
      protrudes_ = std::max(protrudes_, protrudes);
    } else {
      note_large(tree, place, protrudes);
    }
  }
  /// Must be called once for each tool sphere that cuts: after note_cut() was called for all tissue spheres that this
  /// tool sphere changed, and before the next search.
  void end_notes() noexcept;

  /// Computes which motion the non-cutting parts of the tool allow during a cut. Changes `move` (m) and `turn` (rad) to
  /// the nearest motion on which these parts do not penetrate the tissue; they may slide along it. Stores their
  /// contacts. Returns the fraction 0..1 of the changed motion after which a new contact occurs. Contacts are searched
  /// only on the first `longest_path` metres of the motion; if there are none, the fraction is 1.
  double non_cutting_parts_allow(const SphereTree& tree, double longest_path, dvec3& move, dvec3& turn) noexcept;
  /// Moves the proxy as near to the hand as the spheres allow, once per tick. If `gpu` is given and ready, the GPU
  /// searches the first contact.
  void follow(const SphereTree& tree, const Pose& X_WH, ComputePasses* gpu = nullptr) noexcept;

  /// Finds the tissue's spheres near the motion of one tool sphere from the proxy's pose to `to`, with the same result
  /// as SphereTree::near_segment().
  std::size_t near_path(const SphereTree& tree, std::size_t tool_sphere, const Pose& to,
                        std::span<Place> found) const noexcept;

  /// Finds the tissue's spheres near one tool sphere at the proxy's pose. The tool sphere is enlarged by `epsilon` (m).
  /// The result is the same as that of SphereTree::near_segment().
  std::size_t near_here(const SphereTree& tree, std::size_t tool_sphere, double epsilon,
                        std::span<Place> found) noexcept;

  const ToolSpheres& tool() const { return tool_; }
  const Pose& pose() const { return X_W_; }
  std::span<const ProxyContact> contacts() const { return {contacts_.data(), count_}; }
  bool touches() const { return pushed_ > 0; }
  bool sticks() const { return sticks_; }
  /// Returns the unit vector of the sum of all contact normals, each weighted by its push; zero without contact.
  const dvec3& normal() const { return n_W_; }

  /// Paper S2, eq. 7: returns the force on the hand, N. `v_WH`: velocity of the hand, m/s.
  dvec3 force(const dvec3& v_WH) const noexcept;
  /// Paper S2, eq. 8: returns the torque of `force` about the tool's centre of mass, N·m. The force acts at the contact
  /// point.
  dvec3 torque(const dvec3& force) const noexcept;
  /// Returns the point at which the force acts, m: the mean of the contact points, weighted by their pushes.
  dvec3 contact_point() const noexcept;
  dvec3 com() const noexcept { return X_W_ * tool_.com_T; }

  /// Returns the rotation between two orientations as a rotation vector, rad.
  static dvec3 rotation_angle(const dquat& from, const dquat& to) noexcept;
  static dquat turned_by(const dvec3& turn) noexcept;

  static constexpr std::size_t kMostContacts = 12;
  static constexpr double kGap = 1e-7;  // m, distance that the proxy keeps from a sphere

 private:
  // m. After a cut, a tissue sphere may protrude beyond its earlier surface. If it protrudes by at most this length,
  // the margins of all near lists are reduced by the protruding length. If it protrudes farther, only the margins of
  // the near lists around this sphere are reduced.
  static constexpr double kStickOut = 1e-6;

  /// A motion of the tool from the proxy's pose to another pose.
  struct Motion {
    Pose to;
    // shift: m, displacement of the origin of the tool's frame; turn: rotation as the length of a chord of the unit
    // circle
    double shift = 0, turn = 0;
    /// Returns an upper bound of the displacement (m) in this motion of a tool sphere whose centre is at the distance
    /// `arm` (m) from the origin of the tool's frame.
    double way(double arm) const { return shift + turn * arm; }
  };
  /// Near list (Verlet 1967): the tissue's spheres near one tool sphere, in the tree's order. The list is valid until
  /// the tool sphere has moved by the list's margin. So the tree must be searched only once in many ticks.
  struct NearList {
    // m; when this near list was made, every tissue sphere outside the list was at least this far from the tool sphere
    double margin = 0;
    // m, upper bound of the displacement of the tool sphere since this near list was made, plus the sum of `protrudes`
    // over all cuts since then
    double moved = 0;
    // m. The present cut changes tissue spheres; this is the largest distance by which such a sphere protrudes beyond
    // its surface before the cut.
    double protrudes = 0;
    // m, distance from the tool sphere to the nearest sphere of the tissue when the list was made; negative if they
    // overlap
    double free = 0;
    // m, enlargement of the tool sphere (`epsilon` of near_here()) for which the list also has enough margin; negative:
    // the list has no memory for so many spheres, so near_here() searches the tree
    double wider = 0;
    std::size_t count = 0;  // number of spheres in the list
    // if the list was too long for its memory: number of searches that must pass before it is made again
    int refused = 0;
  };
  /// A near list (the tissue spheres near a tool sphere) that is not complete yet.
  struct NextList {
    std::size_t tool_sphere = 0;
    bool active = false;
    dvec3 center{0};                // m, position of the tool sphere for which the list is made
    double margin = 0;              // m
    double moved = 0;               // m, bound of the tool sphere's motion since the search began (NearList::moved)
    SphereTree::PartSearch search;  // search for the spheres of the list
    std::size_t leaves = 0;         // number of the tree's leaves that the search has examined
    std::size_t expected = 0;       // number of leaves that the last complete search examined; 0: none was complete
    std::size_t count = 0;
    std::vector<Place> places;
    std::vector<float> gaps;  // m
  };
  struct Constraint {
    // n: change of the gap per metre of translation along each axis; turn: change of the gap per radian of rotation, m
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
  /// Makes the list of tissue spheres near a tool sphere. `way`: m, bound of the motion for which it must be valid.
  void list_near(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center, double way) noexcept;
  void start_list(const SphereTree& tree, std::size_t tool_sphere, const dvec3& center, double margin) noexcept;
  bool continue_list(const SphereTree& tree, std::size_t leaves) noexcept;
  void use_list() noexcept;
  void prepare_lists(const SphereTree& tree) noexcept;
  double spread_margin(std::size_t tool_sphere, double margin) const noexcept;
  /// Calls visit(place) for the listed tissue spheres whose gap to the tool sphere was at most limit() when the list
  /// was made, and for a few others. The calls may reduce limit().
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
  double lever_;  // m, lever arm that converts rotations (rad) to lengths in project()
  Pose X_W_, X_WH_;
  std::array<ProxyContact, kMostContacts> contacts_;
  std::array<Constraint, kMostContacts> constraints_;
  std::size_t count_ = 0;
  std::vector<double> arm_;      // m, for each tool sphere: distance of its centre from the origin of the tool's frame
  std::vector<NearList> lists_;  // near lists (tissue spheres), one for each tool sphere
  std::size_t room_;             // number of entries for which each list has memory; a multiple of 8
  std::vector<Place> listed_;    // entries of all near lists, one list after the other
  // m, for each entry of listed_: gap to the tool sphere when it was listed; infinite: unused entry
  std::vector<float> gap_;
  NextList next_;
  std::vector<double> moved_before_;         // m, for each near list: value of `moved` at the end of the last tick
  std::vector<SweptBall> swept_;             // balls of one search on the GPU, with their motions
  std::vector<std::size_t> sphere_of_ball_;  // for each ball in swept_: index of its tool sphere
  // m, largest distance by which a cut sphere protrudes beyond its earlier surface since the last end_notes(), if at
  // most kStickOut
  double protrudes_ = 0;
  bool noted_ = false;  // true: since the last end_notes(), a cut sphere has protruded beyond its earlier surface
  double pushed_ = 0;   // m, sum of the pushes of all contacts (distances by which they hold the proxy back)
  dvec3 n_W_{0};
  bool sticks_ = false;
};

}  // namespace typodont::haptics::packing
