// "packing": tissue and tool as sphere packings (paper S2 in docs/papers.md).
#pragma once

#include <optional>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact_method.h"

namespace typodont::haptics::packing {

inline constexpr std::string_view kName = "packing";

/// Reads {"spheres": 36000, "seed": 1, "file": "P.h5", "tool_spheres": 60, "speed_mm_per_s": 1, "density": {"enamel":
/// 1.5, …}, "density_by_contact": false, "as_printed": false, "material": "MATERIAL.json", "tool_mesh": {"file":
/// "HEAD.stl", "unit_mm": 1}}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

/// The packing of a tissue, as this method makes or reads it, and the method's parameters. For another method,
/// packed_by() returns nothing.
struct Packed {
  SpherePacking packing;
  Parameters parameters;
};
/// The parameters of a method "packing"; null for another method.
const Parameters* parameters_of(const SharedContactMethod& method);
std::optional<Packed> packed_by(const SharedContactMethod& method, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
