// The head's step towards the hand, as far as the vertices around it allow.
#pragma once

#include <span>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::vertex {

/// A bound of the head's step: n·step >= -gap.
struct StepBound {
  dvec3 n;     // unit, the way the head is pushed
  double gap;  // m, negative where the head overlaps
};

/// The step nearest to `wanted` that keeps all bounds (dual active set: Goldfarb & Idnani 1983). Where none does, the
/// bounds that overlap keep it only from going deeper. `active`: the bounds that hold the head there.
dvec3 nearest_step(std::span<const StepBound> bounds, const dvec3& wanted, ActivePlanes& active) noexcept;

}  // namespace typodont::haptics::vertex
