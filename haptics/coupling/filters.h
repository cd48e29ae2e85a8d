// Force filters of two published simulators, for comparison. The filters are not passive: without the passivity
// controller, the energy ledger shows how much energy they generate.
#pragma once

#include <optional>
#include <string_view>

#include "engine/base/pose.h"

namespace typodont::haptics {

enum class ForceFilter {
  kNone,
  kSlew,  // the filter of Wang 2009: the force changes by at most δ per tick, in any direction
  // the filter of the vertex deformation method: the force stays constant until the computed force differs from it by
  // `renewal` or more
  kStroke,
};

inline std::optional<ForceFilter> force_filter_named(std::string_view name) noexcept {
  if (name == "none") return ForceFilter::kNone;
  if (name == "slew") return ForceFilter::kSlew;
  if (name == "stroke") return ForceFilter::kStroke;
  return std::nullopt;
}

struct ForceFilterLaw {
  double step = 0.02;    // N per tick, largest change of the force: δ of Wang 2009
  double still = 0.001;  // N, ξ of the vertex deformation method: a force smaller than this counts as zero
  // N; if the computed force differs by this or more from the force of the last tick, the computed force is used
  double renewal = 0.10;
  double cap = 3.0;  // N, λ: largest magnitude of the force
};

/// Returns the filtered force, N. `wanted`: N, computed force; `last`: N, force of the previous tick.
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
