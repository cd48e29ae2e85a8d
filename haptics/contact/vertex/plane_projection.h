// Limits a step of the head towards the hand, by bounds from the vertices around the head.
#pragma once

#include <span>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::vertex {

/// A linear bound on a step (displacement) of the head, which a contact point gives: n·step >= -gap.
struct StepBound {
  dvec3 n;     // unit direction in which the point pushes the head
  double gap;  // m, distance between point and head; negative if they overlap
};

/// Returns the step of the head nearest to `wanted` that satisfies all bounds (dual active-set method: Goldfarb &
/// Idnani 1983). If there is no such step, bounds that the head already violates only prevent a deeper overlap.
/// `active` receives the bounds that limit the result.
dvec3 nearest_step(std::span<const StepBound> bounds, const dvec3& wanted, ActivePlanes& active) noexcept;

}  // namespace typodont::haptics::vertex
