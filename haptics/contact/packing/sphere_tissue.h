// The tissue of the packing method: spheres that cuts shrink, move and remove.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tree.h"

namespace typodont::haptics::packing {

/// How the volume of a partly cut sphere is counted.
enum class Removal {
  kMended,     // what the tool covers of the sphere as it was: the lens of eq. 2
  kAsPrinted,  // eq. 6 to the letter, the shrunk sphere's own volume: about 2r/δ times too much for a small overlap δ
};

/// A sphere as cuts left it. `base` is the sphere before the cut that is under way: as packed, or as an earlier cut
/// from another side left it. Where the sphere is now follows from it by eq. 6.
struct CutSphere {
  dvec3 base{0};           // m, W
  double base_radius = 0;  // m
  double base_volume = 0;  // m³ that counts as its volume
  dvec3 away{0};           // unit, from the tool's path to the base
  double overlap = 0;      // m, the deepest so far; at 2 · base_radius nothing is left
  double tool = 0;         // m, radius of the ball that cut it

  bool operator==(const CutSphere&) const = default;
  double radius() const { return std::max(0.0, base_radius - 0.5 * overlap); }
  dvec3 center() const { return base + 0.5 * overlap * away; }
};

/// One thread at a time. Built at set-up; cut() and set() are noexcept and never allocate.
class SphereTissue {
 public:
  SphereTissue() : SphereTissue(SpherePacking{}, Removal::kMended) {}
  SphereTissue(const SpherePacking& packing, Removal removal);

  std::size_t size() const { return spheres_.size(); }
  const SphereTree& tree() const { return tree_; }
  Tissue tissue(int i) const noexcept { return tissue_[static_cast<std::size_t>(i)]; }
  const CutSphere& sphere(int i) const noexcept { return spheres_[static_cast<std::size_t>(i)]; }
  /// m³ that a sphere stands for: its own volume and its share of the gaps around it, so that all spheres of a tissue
  /// have that tissue's volume.
  double volume(int i) const noexcept;
  /// Of all that is left, m³.
  PerTissue volumes() const noexcept;

  /// Takes away what a ball of radius `r` covers on its way from a to b (S2, eq. 6). Writes the numbers of the spheres
  /// that changed to the front of `changed`, as they were before to that of `before` (which may be empty), and adds the
  /// volume to `removed`, m³. Returns how many changed. `changed` must hold all spheres that the way of the ball can
  /// touch; those that do not fit stay as they are.
  std::size_t cut(const dvec3& a, const dvec3& b, double r, std::span<int> changed, std::span<CutSphere> before,
                  PerTissue& removed) noexcept;
  /// Puts a sphere back as it was at another time.
  void set(int i, const CutSphere& sphere) noexcept;

  /// Of spheres and tree.
  std::size_t bytes() const { return spheres_.size() * (sizeof(CutSphere) + sizeof(Tissue)) + tree_.bytes(); }

 private:
  double counted(const CutSphere& s) const noexcept;

  Removal removal_;
  std::vector<CutSphere> spheres_;
  std::vector<Tissue> tissue_;
  PerTissue share_{};  // by which a sphere's own volume counts: solid over spheres
  SphereTree tree_;
};

}  // namespace typodont::haptics::packing
