// The tissue of the contact model "packing": spheres. A cut makes spheres smaller, moves them, or removes them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tree.h"
#include "haptics/sphere_passes.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::packing {

/// The volume of tissue that a cut removes.
struct Removed {
  PerTissue volume{};  // m³, removed volume of each tissue
  // m³, sum of (removed volume × hardness); multiplied by the specific energy, it gives the cutting energy
  PerTissue hardened{};

  Removed& operator+=(const Removed& other) noexcept {
    for (std::size_t t = 0; t < volume.size(); ++t) volume[t] += other.volume[t], hardened[t] += other.hardened[t];
    return *this;
  }
};

class TriedCut;

/// The tissue as spheres, with their search tree. Used by one thread at a time. Built at set-up; cut() and set() are
/// noexcept and never allocate.
class SphereTissue {
 public:
  SphereTissue() : SphereTissue(SpherePacking{}, Removal::kMended) {}
  /// `cell`: for each sphere the volume of tissue that it represents, m³ (see cell_volumes()). If `cell` is empty, each
  /// sphere represents its own volume times a factor. The factor is the same for all spheres of a tissue, and makes the
  /// sum of their volumes equal to the volume of the tissue.
  SphereTissue(const SpherePacking& packing, Removal removal, std::span<const double> cell = {});

  std::size_t size() const { return tree_.size(); }
  const SphereTree& tree() const { return tree_; }
  // Functions with an int identify a sphere by its index in the packing. Functions with a Place identify it by its
  // place (index) in the tree.
  Tissue tissue(Place place) const noexcept { return tissue_[static_cast<std::size_t>(place)]; }
  Tissue tissue(int i) const noexcept { return tissue(tree_.place_of(i)); }
  const CutSphere& sphere(Place place) const noexcept { return spheres_[static_cast<std::size_t>(place)]; }
  const CutSphere& sphere(int i) const noexcept { return sphere(tree_.place_of(i)); }
  /// Returns the hardness of a sphere as a fraction of its tissue's own hardness (hardness.h). It can exceed 1 if a
  /// density was fitted to a measurement (paper S2, eq. 14).
  double hardness(Place place) const noexcept { return hardness_[static_cast<std::size_t>(place)]; }
  double hardness(int i) const noexcept { return hardness(tree_.place_of(i)); }
  /// Returns true if the hardness of any sphere differs from 1.
  bool graded() const { return graded_; }
  /// Sets tissue and hardness of a sphere, at set-up or after the tissue was painted.
  void set_material(int i, Tissue tissue, double hardness) noexcept;
  /// Returns the volume that a sphere represents, m³: its own volume and its part of the gaps around it.
  double volume(int i) const noexcept { return counted(sphere(i)); }
  /// Returns the volume that a sphere with the state `s` represents, m³.
  double volume_of(const CutSphere& s) const noexcept { return counted(s); }
  /// Returns the remaining volume of each tissue, m³.
  PerTissue volumes() const noexcept;

  /// Removes the tissue that a ball of radius `r` covers on its path from a to b (paper S2, eq. 6). Writes the places
  /// (indices in the tree) of the changed spheres to `changed` and their previous states to `before` (which may be
  /// empty). Adds the removed volume to `removed`. Returns the number of changed spheres. `changed` must have space for
  /// all spheres that the ball can touch; spheres without space are not cut.
  std::size_t cut(const dvec3& a, const dvec3& b, double r, std::span<Place> changed, std::span<CutSphere> before,
                  Removed& removed) noexcept;
  /// Same as cut(), but without a search: the first `found` entries of `changed` already contain the spheres that the
  /// ball can touch.
  std::size_t cut_near(std::size_t found, const dvec3& a, const dvec3& b, double r, std::span<Place> changed,
                       std::span<CutSphere> before, Removed& removed) noexcept;
  /// Sets sphere i back to an earlier state `sphere`, for example for undo.
  void set(int i, const CutSphere& sphere) noexcept;
  /// Sets a sphere to its state after a cut, and adds the removed volume to `removed`.
  void take(int i, const CutSphere& after, Removed& removed) noexcept;
  /// Applies the last cut that `tried` has computed to the tissue, with the same bits as carve(). Calls changes(place,
  /// protrudes) for every changed sphere, where `protrudes` is the distance by which the sphere protrudes beyond its
  /// former surface. Calls ends_ball() after the changes by one of the tool's spheres.
  template <class Changes, class EndsBall>
  void make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept;

  Removal removal() const { return removal_; }

  // Public only because the kernels in the .cpp file need them.
  struct Lanes;
  /// Smallest radius of a cut sphere, as a fraction of its radius before the cut. A smaller sphere is removed, because
  /// its contact could not be felt.
  static constexpr double kLeast = 1e-3;

  /// Returns the size of the memory that the spheres and the tree use, bytes.
  std::size_t bytes() const { return size() * (sizeof(CutSphere) + sizeof(Tissue) + sizeof(float)) + tree_.bytes(); }

 private:
  friend class TriedCut;
  double counted(const CutSphere& s) const noexcept;
  bool after_cut(CutSphere& s, const dvec3& a, const dvec3& b, double r) const noexcept;
  static bool gone(const CutSphere& s) noexcept { return !(s.radius() > kLeast * s.base_radius); }
  /// Sets a sphere without updating the bounding boxes of the tree nodes above it.
  void put(Place place, const CutSphere& s) noexcept {
    spheres_[static_cast<std::size_t>(place)] = s;
    tree_.put(place, s.center(), gone(s) ? 0 : s.radius());
  }
  void renew_boxes(Place place) noexcept;
  void count(Place place, double taken, Removed& removed) const noexcept {
    const auto t = static_cast<std::size_t>(tissue(place));
    removed.volume[t] += taken;
    removed.hardened[t] += taken * hardness(place);
  }

  Removal removal_;
  std::size_t made_ = 0;  // number of cuts that make() has applied
  SphereTree tree_;
  // the arrays have one element for each place (index of a sphere) in the tree
  std::vector<CutSphere> spheres_;
  std::vector<Tissue> tissue_;
  std::vector<float> hardness_;
  bool graded_ = false;
};

/// Computes the cost of a cut by several balls, one after the other, without changing the tissue. As in carve(), the
/// cost of a ball includes only tissue that the previous balls have left. Allocates memory only in the constructor.
/// Servo thread only.
class TriedCut {
 public:
  explicit TriedCut(std::size_t spheres)
      : state_(spheres + SphereTree::kWide), tried_in_(state_.size(), 0) {  // includes unused places at the tree's end
    steps_.resize(kMostSteps + 1);
  }
  /// Starts a new cut that the given number of balls makes.
  void begin(std::size_t balls) noexcept {
    ++number_;
    several_ = balls > 1;
    count_ = 0;
  }
  /// Returns true if SphereTissue::make() can apply the cut, because all its changes could be stored.
  bool complete() const noexcept { return count_ <= kMostSteps; }
  /// Returns the cost of the cut by the next ball, as defined in SphereTissue::cost().
  double add(const SphereTissue& tissue, std::span<const Place> near, const dvec3& a, const dvec3& b, double r,
             const PerTissue& weight) noexcept;

 private:
  friend class SphereTissue;
  static constexpr std::size_t kMostSteps = 16384;
  struct Step {
    Place place{};
    bool first = false;  // true for the first change that a sphere of the tool makes; false for its further changes
    double taken = 0;    // m³, removed volume
    // m, upper bound of the distance by which the changed sphere protrudes beyond its surface before the change
    double protrudes = 0;
    CutSphere after;
  };
  std::vector<Step> steps_;  // changes in the order of carve(); the first count_ are valid
  std::size_t count_ = 0;    // number of changes; greater than kMostSteps if some of them were not stored
  // true: several balls cut, so a ball may cut a sphere that an earlier ball has already changed
  bool several_ = true;
  std::vector<CutSphere> state_;         // for each place: the sphere after the present cut, if several balls cut
  std::vector<std::uint64_t> tried_in_;  // for each place: number of the last cut that changed state_
  std::uint64_t number_ = 0;
};

template <class Changes, class EndsBall>
void SphereTissue::make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept {
  std::optional<Place> unmended;  // a changed sphere in the tree leaf whose bounding boxes must still be updated
  ++made_;
  for (std::size_t k = 0; k < tried.count_; ++k) {
    const TriedCut::Step& step = tried.steps_[k];
    if (step.first) ends_ball();
    if (gone(sphere(step.place))) continue;
    count(step.place, step.taken, removed);
    if (unmended && !tree_.share_leaf(*unmended, step.place)) renew_boxes(*unmended);
    put(step.place, step.after);
    unmended = step.place;
    changes(step.place, step.protrudes);
  }
  if (unmended) renew_boxes(*unmended);
  ends_ball();
}

/// Returns for each sphere the volume of tissue that belongs to it, m³. Each voxel of tissue belongs to the nearest
/// sphere, so the volume includes the gaps around the sphere. The volumes of a tissue's spheres are scaled such that
/// their sum is the volume of the tissue (packing.solid_volume).
std::vector<double> cell_volumes(const SpherePacking& packing, const SphereTree& tree, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
