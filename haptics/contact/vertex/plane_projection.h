// The head's step to the hand within the points' bounds.
#pragma once

#include <cstddef>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::vertex {

/// n·step <= gap, one per point. Eight more elements with huge gaps and finite normals.
struct StepBounds {
  const double *n_x, *n_y, *n_z;  // head to point
  const double* gap;              // m; negative: overlap
  std::size_t count;
};

/// Nearest to `wanted` (Goldfarb & Idnani 1983). If impossible, points inside only prevent more; then 0. `active`:
/// limiting bounds.
dvec3 nearest_step(const StepBounds& bounds, const dvec3& wanted, ActivePlanes& active) noexcept;

}  // namespace typodont::haptics::vertex
