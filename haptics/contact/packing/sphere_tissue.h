// The spheres of the tissue. A cut makes them smaller, moves or removes them. S2: see docs/papers.md.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tree.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::packing {

/// Which volume of a partly cut sphere counts as removed.
enum class Removal {
  // The intersection of the tool with the uncut sphere (lens, eq. 2 of paper S2).
  kMended,
  // The sphere's loss of volume by eq. 6 of paper S2 as printed; at a small overlap δ, 2 radius/δ times too large.
  kAsPrinted,
};

/// A cut sphere: `base` is the sphere before the current cut, from which eq. 6 of paper S2 computes the current sphere.
struct CutSphere {
  dvec3 base{0};           // m, frame W, centre before the current cut
  double base_radius = 0;  // m, radius of the sphere `base`
  double volume = 0;       // m³, remaining volume, including the sphere's part of the gaps between spheres
  // Unit vector from the nearest point of the cutting path to the base's centre.
  dvec3 away{0};
  // Largest overlap with the base, m; at 2 · base_radius the sphere is gone.
  double overlap = 0;
  double tool = 0;          // m, radius of the tool sphere that cut
  double whole_radius = 0;  // m, radius before all cuts
  double whole_volume = 0;  // m³, `volume` before all cuts

  bool operator==(const CutSphere&) const = default;
  double radius() const { return std::max(0.0, base_radius - 0.5 * overlap); }
  dvec3 center() const { return base + 0.5 * overlap * away; }
};

/// The volume of tissue that a cut removes.
struct Removed {
  PerTissue volume{};  // m³, removed volume of each tissue
  // m³, removed volume × hardness; multiplied by the specific energy, it gives the energy of the cut
  PerTissue hardened{};

  Removed& operator+=(const Removed& other) noexcept {
    for (std::size_t t = 0; t < volume.size(); ++t) volume[t] += other.volume[t], hardened[t] += other.hardened[t];
    return *this;
  }
};

class TriedCut;

/// The spheres with their search tree. One thread at a time. cut_near() and set() are noexcept and never allocate.
class SphereTissue {
 public:
  SphereTissue() : SphereTissue(SpherePacking{}, Removal::kMended) {}
  /// `cell`: m³, volume of tissue that belongs to each sphere (cell_volumes()); empty: the sphere's own volume, scaled
  /// so that the sum is the tissue's volume.
  SphereTissue(const SpherePacking& packing, Removal removal, std::span<const double> cell = {});

  std::size_t size() const { return tree_.size(); }
  const SphereTree& tree() const { return tree_; }
  // An int is a sphere's index in the packing, a Place its position in the tree.
  Tissue tissue(Place place) const noexcept { return tissue_[static_cast<std::size_t>(place)]; }
  Tissue tissue(int i) const noexcept { return tissue(tree_.place_of(i)); }
  const CutSphere& sphere(Place place) const noexcept { return spheres_[static_cast<std::size_t>(place)]; }
  const CutSphere& sphere(int i) const noexcept { return sphere(tree_.place_of(i)); }
  /// Hardness of a sphere divided by its tissue's hardness. A material fit (paper S2, eq. 14) can give more than 1.
  double hardness(Place place) const noexcept { return hardness_[static_cast<std::size_t>(place)]; }
  double hardness(int i) const noexcept { return hardness(tree_.place_of(i)); }
  /// Returns true if some sphere's hardness is not 1.
  bool graded() const { return graded_; }
  /// Sets a sphere's tissue and hardness, at set-up or painting.
  void set_material(int i, Tissue tissue, double hardness) noexcept;
  /// Volume of sphere i with its share of the gaps between spheres, m³.
  double volume(int i) const noexcept { return sphere(i).volume; }

  /// Cuts with a ball of radius `r` from a to b (paper S2, eq. 6); adds to `removed`. The first `found` elements of
  /// `changed` are the spheres that the ball may touch. Writes the changed spheres to `changed`, and returns their
  /// number. `before` receives their former states, unless it is empty. `curve`: ToolSpheres::curve of the ball.
  std::size_t cut_near(std::size_t found, const dvec3& a, const dvec3& b, double r, double curve,
                       std::span<Place> changed, std::span<CutSphere> before, Removed& removed) noexcept;
  /// Sets a sphere to an earlier state, for undo.
  void set(int i, const CutSphere& sphere) noexcept;
  /// Applies the cut that `tried` has computed; the result is bit-identical to that of carve(). Calls changes(place,
  /// protrudes) for each changed sphere, and ends_ball() for each tool sphere.
  template <class Changes, class EndsBall>
  void make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept;

  Removal removal() const { return removal_; }

  // Public because the SIMD kernels use it.
  struct Lanes;
  /// Smallest ratio of a sphere's radius to that before the cut. A smaller sphere is removed, as it cannot be felt.
  static constexpr double kMin = 1e-3;

 private:
  friend class TriedCut;
  double left_of(const CutSphere& s, double curve) const noexcept;
  bool after_cut(CutSphere& s, const dvec3& a, const dvec3& b, double r, double curve) const noexcept;
  static bool gone(const CutSphere& s) noexcept { return !(s.radius() > kMin * s.base_radius); }
  /// Sets a sphere without updating the bounding boxes above it in the tree.
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
  // The following three arrays are indexed by Place.
  std::vector<CutSphere> spheres_;
  std::vector<Tissue> tissue_;
  std::vector<float> hardness_;
  bool graded_ = false;
};

/// Computes the energy of a cut by several balls without changing the tissue; each ball cuts what the earlier balls
/// left. Servo thread only; allocates only in the constructor.
class TriedCut {
 public:
  explicit TriedCut(std::size_t spheres)
      : state_(spheres + SphereTree::kLeafSize),
        tried_in_(state_.size(), 0) {  // includes unused positions at the tree's end
    steps_.resize(kMaxSteps + 1);
  }
  /// Begins a cut by `balls` balls.
  void begin(std::size_t balls) noexcept {
    ++number_;
    several_ = balls > 1;
    count_ = 0;
  }
  /// Returns true if all changes could be stored.
  bool complete() const noexcept { return count_ <= kMaxSteps; }
  /// Adds a ball of radius `r` that moves from a to b. Returns Σ removed volume × hardness × `weight` of its tissue.
  double add(const SphereTissue& tissue, std::span<const Place> near, const dvec3& a, const dvec3& b, double r,
             double curve, const PerTissue& weight) noexcept;

 private:
  friend class SphereTissue;
  static constexpr std::size_t kMaxSteps = 16384;
  struct Step {
    Place place{};
    bool first = false;  // true: first change by this tool sphere
    double taken = 0;    // m³, removed volume
    // m, distance by which the changed sphere protrudes from its former surface
    double protrudes = 0;
    CutSphere after;
  };
  std::vector<Step> steps_;  // changes in the order of packing::carve(); the first count_ are valid
  std::size_t count_ = 0;    // number of changes; above kMaxSteps, only the first kMaxSteps are stored
  // true: several balls cut, so a ball may cut a sphere that an earlier ball has cut
  bool several_ = true;
  std::vector<CutSphere> state_;         // each sphere's state after the current cut, with several balls
  std::vector<std::uint64_t> tried_in_;  // for each sphere: number of the cut that last changed state_
  std::uint64_t number_ = 0;
};

template <class Changes, class EndsBall>
void SphereTissue::make(const TriedCut& tried, Removed& removed, Changes&& changes, EndsBall&& ends_ball) noexcept {
  std::optional<Place> unmended;  // sphere whose bounding boxes must still be updated
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

/// Volume of each sphere's cell, m³: each voxel of tissue belongs to its nearest sphere, so the gaps between spheres
/// are included. Scaled to the sum packing.solid_volume.
std::vector<double> cell_volumes(const SpherePacking& packing, const SphereTree& tree, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
