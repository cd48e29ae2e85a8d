// Limits the head's step towards the hand by the vertices around the head.
#pragma once

#include <span>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::vertex {

/// A bound of the head's step: n·step >= -gap.
struct StepBound {
  dvec3 n;     // unit, direction in which the head is pushed
  double gap;  // m, negative if the head overlaps
};

/// The step nearest to `wanted` that satisfies all bounds (dual active set: Goldfarb & Idnani 1983). If no such step
/// exists, bounds that the head overlaps only prevent deeper overlap. `active`: receives the bounds that hold the
/// head.
dvec3 nearest_step(std::span<const StepBound> bounds, const dvec3& wanted, ActivePlanes& active) noexcept;

}  // namespace typodont::haptics::vertex
