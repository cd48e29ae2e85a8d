// A cut in a packing by one ball.
#pragma once

#include <algorithm>
#include <span>

#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

/// Cuts with a ball of radius `r` from a to b, m. Returns the number of changed spheres (SphereTissue::cut_near).
inline std::size_t cut_with_ball(SphereTissue& tissue, const dvec3& a, const dvec3& b, double r,
                                 std::span<Place> changed, std::span<CutSphere> before, Removed& removed) {
  const std::size_t found = std::min(tissue.tree().near_segment(a, b, r, changed), changed.size());
  return tissue.cut_near(found, a, b, r, r, changed, before, removed);
}

}  // namespace typodont::haptics::packing
