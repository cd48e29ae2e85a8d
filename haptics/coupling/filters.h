// The force filters of two of the papers this workbench grew from, for comparison. They are not passive: the ledger
// shows what they generate, and with the passivity controller on they cannot.
#pragma once

#include <optional>
#include <string_view>

#include "engine/base/pose.h"

namespace typodont::haptics {

enum class ForceFilter {
  kNone,
  kSlew,    // Wang 2009: the force moves by at most δ a tick, in whichever direction
  kStroke,  // vertex-deformation simulator: one constant force per stroke, renewed when the computed one departs
};

inline std::optional<ForceFilter> force_filter_named(std::string_view name) noexcept {
  if (name == "none") return ForceFilter::kNone;
  if (name == "slew") return ForceFilter::kSlew;
  if (name == "stroke") return ForceFilter::kStroke;
  return std::nullopt;
}

struct ForceFilterLaw {
  double step = 0.02;     // N a tick: δ of Wang 2009
  double still = 0.001;   // N: ξ, a force below this is none
  double renewal = 0.10;  // N: ζ, the stroke's force holds while the computed one differs by less
  double cap = 3.0;       // N: λ
};

/// `last`: the force given in the tick before.
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
