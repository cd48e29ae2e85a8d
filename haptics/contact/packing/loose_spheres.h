// Finds the loose pieces that a cut detached. A loose piece is a set of spheres that is no longer linked with the rest
// of its body.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

/// Finds loose pieces. Carver thread only. The result depends only on the spheres, so it is deterministic. Spheres that
/// lie close together in the packing are linked. A link breaks if one of its two spheres disappears. It also breaks if
/// the gap between them has grown by more than 0.1 mm since the start and is larger than the sum of their radii. If a
/// tool passes between two spheres, both shrink away from each other, and the link breaks. The gap on the far side of a
/// cut sphere does not change, so its links on that side remain. Flood fills start at the spheres that lost links, and
/// grow along links at equal speed until they meet. A flood fill that ends without meeting another one is a loose
/// piece. Bodies that were separate at the start (two teeth) do not count as loose pieces.
class LooseSpheres {
 public:
  LooseSpheres(const SpherePacking& packing, const SphereTree& tree);

  /// The state of a sphere before a cut changed it.
  struct Changed {
    int sphere;
    dvec3 center;   // m, centre of the sphere
    double radius;  // m, radius of the sphere
  };
  /// Call this after each cut, with all spheres that the cut changed (each listed once). Returns the loose pieces that
  /// this cut detached, as lists of spheres. The function does not remove these spheres from the tissue.
  std::vector<std::vector<int>> after_cut(const SphereTissue& tissue, std::span<const Changed> changed);
  /// Returns the number of separate bodies at the start.
  int bodies() const { return bodies_; }

 private:
  struct Link {
    int to;
    float gap;  // m, gap between the two spheres at the start
  };
  std::span<const Link> links(int i) const {
    const auto k = static_cast<std::size_t>(i);
    return std::span(links_).subspan(first_[k], first_[k + 1] - first_[k]);
  }
  static bool hold(const SphereTissue& tissue, int i, const Link& link);
  bool linked_before(const SphereTissue& tissue, const Changed& i, const Link& link) const;
  void flood(const SphereTissue& tissue, std::span<const int> seeds, std::vector<std::vector<int>>& loose);

  std::vector<std::size_t> first_;  // for each sphere: index of its first link
  std::vector<Link> links_;
  std::vector<int> body_;  // for each sphere: index of its body
  int bodies_ = 0;
  std::vector<Changed> before_;  // for each sphere: its state before the most recent cut that changed it
  std::vector<unsigned> cut_;    // for each sphere: number of the cut that last changed it
  unsigned cuts_ = 0;
  std::vector<unsigned> seen_;  // for each sphere: number of the search that last reached it
  std::vector<int> flood_;      // for each sphere: the flood fill that reached it
  unsigned search_ = 0;
};

}  // namespace typodont::haptics::packing
