// First hit of a moving sphere, found without the tree's boxes.
#pragma once

#include "haptics/contact/packing/sphere_pair.h"
#include "haptics/contact/packing/sphere_tree.h"

namespace typodont::haptics::packing {

inline SphereTree::Hit brute_force(const SphereTree& tree, const dvec3& p, double r, const dvec3& m) {
  SphereTree::Hit best;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const double rb = tree.radius(static_cast<int>(i));
    if (!(rb > 0)) continue;
    const double t = contact_time(tree.center(static_cast<int>(i)) - p, m, rb + r);
    if (t < best.t) best = {t, static_cast<int>(i)};
  }
  return best;
}

}  // namespace typodont::haptics::packing
