// Finds spheres that a cut has separated from their body.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

/// Carver thread only; deterministic. Neighbouring spheres are linked. A link breaks if a sphere disappears, or if the
/// gap between both has grown by 0.1 mm and exceeds the sum of radii. Flood fills along links find loose pieces.
class LooseSpheres {
 public:
  LooseSpheres(const SpherePacking& packing, const SphereTree& tree);

  /// A sphere before a cut changed it.
  struct Changed {
    int sphere;
    dvec3 center;   // m, centre of the sphere
    double radius;  // m, radius of the sphere
  };
  /// Lists of spheres in loose pieces after a cut; they stay in the tissue. `changed`: spheres that the cut changed.
  std::vector<std::vector<int>> after_cut(const SphereTissue& tissue, std::span<const Changed> changed);

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
  std::vector<int> body_;        // for each sphere: index of its connected body
  std::vector<Changed> before_;  // for each sphere: its state before its last change
  std::vector<unsigned> cut_;    // for each sphere: number of the cut that last changed it
  unsigned cuts_ = 0;
  std::vector<unsigned> seen_;  // for each sphere: the search that last reached it
  std::vector<int> flood_;      // for each sphere: the flood fill that reached it
  unsigned search_ = 0;
};

}  // namespace typodont::haptics::packing
