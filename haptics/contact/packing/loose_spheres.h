// Spheres that a cut has unlinked from their body.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

/// Carver thread; deterministic. Close spheres are linked. A link breaks if one disappears, or the gap has grown by 0.1
/// mm since the start and exceeds the sum of radii: both shrink away from a tool between them, while links on the far
/// side stay. Floods from spheres that lost links grow alike until they meet; one that ends alone is loose. Bodies
/// separate at the start are not.
class LooseSpheres {
 public:
  LooseSpheres(const SpherePacking& packing, const SphereTree& tree);

  /// Before a cut changed it.
  struct Changed {
    int sphere;
    dvec3 center;   // m, centre of the sphere
    double radius;  // m, radius of the sphere
  };
  /// After each cut, with the changed spheres, each once. The pieces stay in the tissue.
  std::vector<std::vector<int>> after_cut(const SphereTissue& tissue, std::span<const Changed> changed);
  /// At the start.
  int bodies() const { return bodies_; }

 private:
  struct Link {
    int to;
    float gap;  // m, at the start
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
  std::vector<Changed> before_;  // before its last change, per sphere
  std::vector<unsigned> cut_;    // cut that last changed it
  unsigned cuts_ = 0;
  std::vector<unsigned> seen_;  // search that last reached it
  std::vector<int> flood_;      // flood that reached it
  unsigned search_ = 0;
};

}  // namespace typodont::haptics::packing
