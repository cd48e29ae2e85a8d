// Cuts make spheres smaller, move or remove them.
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
  // m³ × hardness; times specific energy, the cutting energy
  PerTissue hardened{};

  Removed& operator+=(const Removed& other) noexcept {
    for (std::size_t t = 0; t < volume.size(); ++t) volume[t] += other.volume[t], hardened[t] += other.hardened[t];
    return *this;
  }
};

class TriedCut;

/// With its tree. One thread at a time. cut() and set() are noexcept, never allocate.
class SphereTissue {
 public:
  SphereTissue() : SphereTissue(SpherePacking{}, Removal::kMended) {}
  /// `cell`: m³ per sphere (cell_volumes()); empty: own volumes, scaled to the tissue's.
  SphereTissue(const SpherePacking& packing, Removal removal, std::span<const double> cell = {});

  std::size_t size() const { return tree_.size(); }
  const SphereTree& tree() const { return tree_; }
  // int: index in the packing; Place: in the tree.
  Tissue tissue(Place place) const noexcept { return tissue_[static_cast<std::size_t>(place)]; }
  Tissue tissue(int i) const noexcept { return tissue(tree_.place_of(i)); }
  const CutSphere& sphere(Place place) const noexcept { return spheres_[static_cast<std::size_t>(place)]; }
  const CutSphere& sphere(int i) const noexcept { return sphere(tree_.place_of(i)); }
  /// Of its tissue's own (dense_tissue.h); above 1 if fitted (S2, eq. 14).
  double hardness(Place place) const noexcept { return hardness_[static_cast<std::size_t>(place)]; }
  double hardness(int i) const noexcept { return hardness(tree_.place_of(i)); }
  /// Some differ from 1.
  bool graded() const { return graded_; }
  /// At set-up, or after painting.
  void set_material(int i, Tissue tissue, double hardness) noexcept;
  /// m³, with its part of the gaps.
  double volume(int i) const noexcept { return counted(sphere(i)); }
  /// m³, in state `s`.
  double volume_of(const CutSphere& s) const noexcept { return counted(s); }
  /// Returns the remaining volume of each tissue, m³.
  PerTissue volumes() const noexcept;

  /// A ball of `r` from a to b (S2, eq. 6). `changed`: places; `before` (may be empty): former states; adds to
  /// `removed`; returns how many. `changed` must have room for all touched ones: others are not cut.
  std::size_t cut(const dvec3& a, const dvec3& b, double r, std::span<Place> changed, std::span<CutSphere> before,
                  Removed& removed) noexcept;
  /// Without search: the first `found` of `changed` are the touched ones.
  std::size_t cut_near(std::size_t found, const dvec3& a, const dvec3& b, double r, std::span<Place> changed,
                       std::span<CutSphere> before, Removed& removed) noexcept;
  /// To an earlier state, as for undo.
  void set(int i, const CutSphere& sphere) noexcept;
  /// After a cut; adds to `removed`.
  void take(int i, const CutSphere& after, Removed& removed) noexcept;
  /// The last cut of `tried`, with carve()'s bits. changes(place, protrudes) per sphere, ends_ball() per tool sphere.
  template <class Changes, class EndsBall>
  void make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept;

  Removal removal() const { return removal_; }

  // Public for the kernels.
  struct Lanes;
  /// Of the radius before; smaller ones go: they could not be felt.
  static constexpr double kLeast = 1e-3;

  /// Bytes, spheres and tree.
  std::size_t bytes() const { return size() * (sizeof(CutSphere) + sizeof(Tissue) + sizeof(float)) + tree_.bytes(); }

 private:
  friend class TriedCut;
  double counted(const CutSphere& s) const noexcept;
  bool after_cut(CutSphere& s, const dvec3& a, const dvec3& b, double r) const noexcept;
  static bool gone(const CutSphere& s) noexcept { return !(s.radius() > kLeast * s.base_radius); }
  /// Without the boxes above.
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
  // by place
  std::vector<CutSphere> spheres_;
  std::vector<Tissue> tissue_;
  std::vector<float> hardness_;
  bool graded_ = false;
};

/// Cost of several balls in turn, without changing anything; each meets only what the earlier left. Allocates in the
/// constructor only. Servo thread.
class TriedCut {
 public:
  explicit TriedCut(std::size_t spheres)
      : state_(spheres + SphereTree::kWide), tried_in_(state_.size(), 0) {  // includes unused places at the tree's end
    steps_.resize(kMostSteps + 1);
  }
  /// For so many balls.
  void begin(std::size_t balls) noexcept {
    ++number_;
    several_ = balls > 1;
    count_ = 0;
  }
  /// All changes were stored.
  bool complete() const noexcept { return count_ <= kMostSteps; }
  /// As SphereTissue::cost().
  double add(const SphereTissue& tissue, std::span<const Place> near, const dvec3& a, const dvec3& b, double r,
             const PerTissue& weight) noexcept;

 private:
  friend class SphereTissue;
  static constexpr std::size_t kMostSteps = 16384;
  struct Step {
    Place place{};
    bool first = false;  // first change by this tool sphere
    double taken = 0;    // m³, removed volume
    // m beyond the former surface
    double protrudes = 0;
    CutSphere after;
  };
  std::vector<Step> steps_;  // carve()'s order; count_ valid
  std::size_t count_ = 0;    // above kMostSteps: not all stored
  // a ball may cut what an earlier one has
  bool several_ = true;
  std::vector<CutSphere> state_;         // after the present cut, with several balls
  std::vector<std::uint64_t> tried_in_;  // cut that last changed state_
  std::uint64_t number_ = 0;
};

template <class Changes, class EndsBall>
void SphereTissue::make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept {
  std::optional<Place> unmended;  // boxes must still follow
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

/// m³: each voxel of tissue belongs to its nearest sphere, so gaps are included; scaled to packing.solid_volume.
std::vector<double> cell_volumes(const SpherePacking& packing, const SphereTree& tree, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
