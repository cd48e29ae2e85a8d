// Finds the step of the head towards the hand that the contact points around the head allow.
#pragma once

#include <cstddef>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::vertex {

/// Linear bounds on a step (displacement) of the head: n·step <= gap. Each contact point gives one bound. The arrays
/// must have at least eight more elements than `count`. In these additional elements, the gaps must be very large and
/// the normals finite.
struct StepBounds {
  const double *n_x, *n_y, *n_z;  // unit direction from the head to the contact point
  const double* gap;              // m, distance between point and head; negative if they overlap
  std::size_t count;
};

/// Returns the step of the head that satisfies all bounds and is nearest to `wanted` (dual active-set method: Goldfarb
/// & Idnani 1983). If no step satisfies all bounds, the search is repeated with weaker bounds: a point that is already
/// inside the head then only prevents a deeper overlap. If this also fails, the step is 0. `active` receives the bounds
/// that limit the result.
dvec3 nearest_step(const StepBounds& bounds, const dvec3& wanted, ActivePlanes& active) noexcept;

}  // namespace typodont::haptics::vertex
