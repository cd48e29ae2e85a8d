// The tissue of the contact model "packing": spheres. A cut makes spheres smaller, moves them, or removes them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tree.h"
#include "haptics/sphere_passes.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::packing {

/// The tissue that a cut removes.
struct Removed {
  PerTissue volume{};  // m³, removed volume of each tissue
  // m³, removed volume times hardness; the product with the specific energy is the cutting energy
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
  /// sphere represents its own volume times a factor; for each tissue this factor makes the sum equal to the tissue's
  /// volume.
  SphereTissue(const SpherePacking& packing, Removal removal, std::span<const double> cell = {});

  std::size_t size() const { return spheres_.size(); }
  const SphereTree& tree() const { return tree_; }
  Tissue tissue(int i) const noexcept { return tissue_[static_cast<std::size_t>(i)]; }
  const CutSphere& sphere(int i) const noexcept { return spheres_[static_cast<std::size_t>(i)]; }
  /// Returns the hardness of a sphere as a fraction of its tissue's own hardness (hardness.h). It can exceed 1 if a
  /// density was fitted to a measurement (eq. 14).
  double hardness(int i) const noexcept { return hardness_[static_cast<std::size_t>(i)]; }
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

  /// Removes the tissue that a ball of radius `r` covers on its path from a to b (paper S2, eq. 6). Writes the indices
  /// of the changed spheres to `changed` and their previous states to `before` (which may be empty). Adds the removed
  /// volume to `removed`. Returns the number of changed spheres. `changed` must have space for all spheres that the
  /// ball can touch; the others are not cut.
  std::size_t cut(const dvec3& a, const dvec3& b, double r, std::span<int> changed, std::span<CutSphere> before,
                  Removed& removed) noexcept;
  /// Same as cut(), but without a search: the first `found` entries of `changed` already contain the spheres that the
  /// ball can touch.
  std::size_t cut_near(std::size_t found, const dvec3& a, const dvec3& b, double r, std::span<int> changed,
                       std::span<CutSphere> before, Removed& removed) noexcept;
  /// Returns the cost of a cut by one ball: the sum over all spheres in `near` of removed volume (m³) × hardness ×
  /// `weight` of the tissue. For several balls that overlap, see class TriedCut.
  double cost(std::span<const int> near, const dvec3& a, const dvec3& b, double r,
              const PerTissue& weight) const noexcept;
  /// Sets a sphere back to an earlier state.
  void set(int i, const CutSphere& sphere) noexcept;
  /// Sets a sphere to its state after a cut, and adds the removed volume to `removed`.
  void take(int i, const CutSphere& after, Removed& removed) noexcept;
  /// Applies the last cut that `tried` computed to the tissue, with the same bits as carve(). Calls changes(number,
  /// sphere before) for every change, and ends_ball() after the changes by one of the tool's spheres.
  template <class Changes, class EndsBall>
  void make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept;

  Removal removal() const { return removal_; }
  std::span<const CutSphere> spheres() const { return spheres_; }

  /// Returns the memory used by the spheres and the tree, bytes.
  std::size_t bytes() const {
    return spheres_.size() * (sizeof(CutSphere) + sizeof(Tissue) + sizeof(float)) + tree_.bytes();
  }

 private:
  friend class TriedCut;
  double counted(const CutSphere& s) const noexcept;
  bool after_cut(CutSphere& s, const dvec3& a, const dvec3& b, double r) const noexcept;
  bool gone(const CutSphere& s) const noexcept;
  void put(int i, const CutSphere& sphere) noexcept;
  void count(int i, double taken, Removed& removed) const noexcept;

  Removal removal_;
  std::vector<CutSphere> spheres_;
  std::vector<Tissue> tissue_;
  std::vector<float> hardness_;
  bool graded_ = false;
  SphereTree tree_;
};

/// Computes the cost of a cut by several balls, one after the other, without changing the tissue. Each ball pays only
/// for the tissue that the previous balls left, as in carve(). Allocates memory only in the constructor. Servo thread.
class TriedCut {
 public:
  explicit TriedCut(std::size_t spheres) : state_(spheres), tried_in_(spheres, 0) { steps_.reserve(kMostSteps); }
  /// Starts a new cut.
  void begin() noexcept {
    ++number_;
    steps_.clear();
    complete_ = true;
  }
  /// Returns true if SphereTissue::make() can apply this cut, because all its changes were stored.
  bool complete() const noexcept { return complete_; }
  /// Returns the cost of the next ball, as defined in SphereTissue::cost().
  double add(const SphereTissue& tissue, std::span<const int> near, const dvec3& a, const dvec3& b, double r,
             const PerTissue& weight) noexcept;

 private:
  friend class SphereTissue;
  static constexpr std::size_t kMostSteps = 16384;
  struct Step {
    int sphere;
    bool first;    // true for the first change that a tool sphere causes
    double taken;  // m³, removed volume
    CutSphere after;
  };
  std::vector<Step> steps_;  // changes in the order of carve()
  bool complete_ = false;
  std::vector<CutSphere> state_;         // for each sphere: its state after the present cut, if the cut changed it
  std::vector<std::uint64_t> tried_in_;  // for each sphere: number of the last cut that changed state_
  std::uint64_t number_ = 0;
};

template <class Changes, class EndsBall>
void SphereTissue::make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept {
  // index of a sphere in the leaf of the tree whose boxes are not updated yet; -1: there is no such leaf
  int unmended = -1;
  for (const TriedCut::Step& step : tried.steps_) {
    const int i = step.sphere;
    if (step.first) ends_ball();
    const CutSphere before = sphere(i);
    if (gone(before)) continue;
    count(i, step.taken, removed);
    if (unmended >= 0 && !tree_.share_leaf(unmended, i)) tree_.mend_above(unmended);
    put(unmended = i, step.after);
    changes(i, before);
  }
  if (unmended >= 0) tree_.mend_above(unmended);
  ends_ball();
}

/// Returns for each sphere the volume of tissue that belongs to it, m³. The tissue of each voxel counts for the nearest
/// sphere, so the volume includes the gaps around the sphere. The volumes of a tissue's spheres are scaled such that
/// their sum is the volume of the tissue (packing.solid_volume).
std::vector<double> cell_volumes(const SpherePacking& packing, const SphereTree& tree, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
