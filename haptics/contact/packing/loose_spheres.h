// Finds the pieces that a cut detached: spheres that are no longer connected with the body to which they belonged.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

/// Finds the pieces that cuts detach. Carver thread. The result depends on the spheres only: equal cuts give equal
/// pieces. Spheres that lie close together in the packing are linked. A link remains while both spheres exist and the
/// gap between them is less than the sum of their radii, or has hardly grown since the start. If a tool has passed
/// between two spheres, both have shrunk away from each other; a sphere that was cut on one side keeps its distance
/// to the spheres on its far side. Flood fills start around the spheres that lost links, and grow over links at equal
/// speed until they meet. A fill that ends without meeting another fill has covered a loose piece. Bodies that were
/// separate at the start (two teeth) are not loose: only the smaller parts of one original body are.
class LooseSpheres {
 public:
  LooseSpheres(const SpherePacking& packing, const SphereTree& tree);

  /// A sphere that a cut changed, in its previous state.
  struct Changed {
    int sphere;
    dvec3 center;   // m
    double radius;  // m
  };
  /// Call after a cut that changed these spheres, each listed once. Returns the pieces that this cut detached, as
  /// lists of spheres; the tissue still contains them.
  std::vector<std::vector<int>> after_cut(const SphereTissue& tissue, std::span<const Changed> changed);
  /// Number of separate bodies at the start.
  int bodies() const { return bodies_; }

 private:
  struct Link {
    int to;
    float gap;  // m, gap at the start
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
  std::vector<int> body_;  // for each sphere: the body to which it belongs
  int bodies_ = 0;
  std::vector<Changed> before_;  // for each sphere: its state before the cut that last changed it
  std::vector<unsigned> cut_;    // for each sphere: number of the cut that last changed it
  unsigned cuts_ = 0;
  std::vector<unsigned> seen_;  // for each sphere: number of the search that last reached it
  std::vector<int> flood_;      // for each sphere: the flood fill that reached it
  unsigned search_ = 0;
};

}  // namespace typodont::haptics::packing
