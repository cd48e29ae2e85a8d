// Force filters of two published simulators, for comparison. They are not passive: without the passivity controller,
// the energy ledger shows the energy that they generate.
#pragma once

#include "engine/base/pose.h"

namespace typodont::haptics {

enum class ForceFilter {
  kNone,
  kSlew,  // Wang 2009: the force changes by at most δ (`step`) per tick, in any direction
  // Simulator with vertex deformation: the force is constant until the computed force differs from it by `renewal`.
  kStroke,
};

struct ForceFilterLaw {
  double step = 0.02;    // N, largest change per tick (the paper's δ)
  double still = 0.001;  // N; a smaller computed force counts as zero (the paper's ξ)
  // N; the force changes only if the computed force differs from it by more than this
  double renewal = 0.10;
  double cap = 3.0;  // N, largest magnitude of the force (the paper's λ)
};

/// Filtered force, N. `wanted`: computed force; `last`: filtered force of the last tick.
inline dvec3 filter_force(ForceFilter filter, const ForceFilterLaw& law, const dvec3& wanted,
                          const dvec3& last) noexcept {
  if (filter == ForceFilter::kSlew) {
    const dvec3 change = wanted - last;
    const double size = glm::length(change);
    return size > law.step ? last + change * (law.step / size) : wanted;
  }
  if (filter == ForceFilter::kStroke) {
    const double size = glm::length(wanted);
    if (size < law.still) return dvec3(0);
    if (glm::length(wanted - last) < law.renewal && glm::length(last) > 0) return last;
    return size > law.cap ? wanted * (law.cap / size) : wanted;
  }
  return wanted;
}

}  // namespace typodont::haptics
