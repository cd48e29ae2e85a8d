// The contact model "packing": tissue and tool are sphere packings (paper S2 in docs/papers.md).
#pragma once

#include <optional>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact_method.h"

namespace typodont::haptics::packing {

inline constexpr std::string_view kName = "packing";

/// Creates the method from its parameters in a scene file, for example {"spheres": 36000, "seed": 1, "file": "P.h5",
/// "tool_spheres": 60, "speed_mm_per_s": 1, "density": {"enamel": 1.5, …}, "density_by_contact": false, "as_printed":
/// false, "material": "MATERIAL.json", "tool_mesh": {"file": "HEAD.stl", "unit_mm": 1}}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

/// The packing that a method "packing" computes for a tissue or reads from a file, and the parameters of this method.
/// packed_by() returns nothing for a method of another contact model.
struct Packed {
  SpherePacking packing;
  Parameters parameters;
};
/// Returns the parameters of a method "packing"; null for another method.
const Parameters* parameters_of(const SharedContactMethod& method);
std::optional<Packed> packed_by(const SharedContactMethod& method, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
