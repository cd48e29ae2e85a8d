// Finds the step that brings the head as near to the hand as the contact points allow.
#pragma once

#include <cstddef>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::vertex {

/// Bounds of a step of the head: n·step <= gap for each contact point. For SIMD, the arrays have eight more elements,
/// with huge gaps and finite normals.
struct StepBounds {
  const double *n_x, *n_y, *n_z;  // unit vector from the head to each point
  const double* gap;              // m, distance of each point from the head; negative: overlap
  std::size_t count;
};

/// Allowed step nearest to `wanted` (Goldfarb & Idnani 1983). If there is none, points inside the head only prevent a
/// deeper overlap; if there is still none, the step is 0. `active`: receives the bounds that limit the step.
dvec3 nearest_step(const StepBounds& bounds, const dvec3& wanted, ActivePlanes& active) noexcept;

}  // namespace typodont::haptics::vertex
