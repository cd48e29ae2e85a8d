// The contact method "packing": tissue and tool consist of spheres (paper S2 in docs/papers.md).
#pragma once

#include <optional>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact_method.h"

namespace typodont::haptics::packing {

inline constexpr std::string_view kName = "packing";

/// Reads the parameters, and creates the method with them. Throws Error.
SharedContactMethod read(Keys& keys);

/// A packing that was computed or read, with the parameters of the method.
struct Packed {
  SpherePacking packing;
  Parameters parameters;
};
/// Empty if `method` is another method.
std::optional<Packed> packed_by(const SharedContactMethod& method, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
