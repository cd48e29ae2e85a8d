// The head's step towards the hand, as far as the vertices around it allow.
#pragma once

#include <span>

#include "engine/base/pose.h"

namespace typodont::haptics::vertex {

/// A bound of the head's step: n·step >= -gap.
struct StepBound {
  dvec3 n;     // unit, the way the head is pushed
  double gap;  // m, negative where the head overlaps
};

/// The step nearest to `wanted` that keeps all bounds (dual active set: Goldfarb & Idnani 1983). Where none does, the
/// bounds that overlap keep it only from going deeper.
dvec3 nearest_step(std::span<const StepBound> bounds, const dvec3& wanted) noexcept;

}  // namespace typodont::haptics::vertex
