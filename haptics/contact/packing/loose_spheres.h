// What a cut leaves without hold: spheres that no longer hang together with the body they were part of.
#pragma once

#include <span>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

/// Carver thread. A function of the spheres alone: equal cuts, equal pieces.
///
/// Spheres that lie close in the packing are linked. A link lasts while both are there and the gap between them is
/// less than the sum of their radii, or hardly wider than at the start: spheres between which a tool has passed shrank
/// away from it and from each other, while a sphere that is cut down keeps its distance to those on its far side.
/// Around the spheres that lost links, floods spread over links at the same pace until they have met. One that ends
/// alone went round a loose piece. What was apart before anything was cut (two teeth) stays: only of what was one body
/// the smaller part is loose.
class LooseSpheres {
 public:
  LooseSpheres(const SpherePacking& packing, const SphereTree& tree);

  /// A sphere that a cut changed, and what it was before.
  struct Changed {
    int sphere;
    dvec3 center;   // m
    double radius;  // m
  };
  /// After a cut that changed these spheres, each named once: the pieces that it set loose, which are still in the
  /// tissue. Lists of spheres.
  std::vector<std::vector<int>> after_cut(const SphereTissue& tissue, std::span<const Changed> changed);
  /// How many bodies there were at the start.
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
  bool held_before(const SphereTissue& tissue, const Changed& i, const Link& link) const;
  void flood(const SphereTissue& tissue, std::span<const int> seeds, std::vector<std::vector<int>>& loose);

  std::vector<std::size_t> first_;  // of each sphere's links
  std::vector<Link> links_;
  std::vector<int> body_;  // of each sphere
  int bodies_ = 0;
  std::vector<Changed> before_;  // of each sphere, in the cut that last changed it …
  std::vector<unsigned> cut_;    // … and which cut that was
  unsigned cuts_ = 0;
  std::vector<unsigned> seen_;  // in which search a sphere was last reached …
  std::vector<int> flood_;      // … and by which flood
  unsigned search_ = 0;
};

}  // namespace typodont::haptics::packing
