// Limits a step of the head towards the hand, by bounds from the vertices around the head.
#pragma once

#include <cstddef>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::vertex {

/// Linear bounds on a step (displacement) of the head: n·step <= gap. Each contact point gives one bound. The arrays
/// must have at least eight more elements than `count`; in these, the gaps must be very large and the normals finite.
struct StepBounds {
  const double *n_x, *n_y, *n_z;  // unit direction from the head to the contact point
  const double* gap;              // m, distance between point and head; negative if they overlap
  std::size_t count;
};

/// Returns the step of the head nearest to `wanted` that satisfies all bounds (dual active-set method: Goldfarb &
/// Idnani 1983). If there is no such step, bounds that the head already violates only prevent a deeper overlap.
/// `active` receives the bounds that limit the result.
dvec3 nearest_step(const StepBounds& bounds, const dvec3& wanted, ActivePlanes& active) noexcept;

}  // namespace typodont::haptics::vertex
