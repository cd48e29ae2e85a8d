// The contact method "packing": tissue and tool consist of spheres (S2 in docs/papers.md).
#pragma once

#include <optional>

#include "engine/contract/sphere_packing.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact_method.h"

namespace typodont::haptics::packing {

inline constexpr std::string_view kName = "packing";

/// Reads the parameters, for example {"spheres": 36000, "seed": 1, "file": "P.h5", "tool_spheres": 60,
/// "speed_mm_per_s": 1, "density": {"enamel": 1.5, …}, "density_by_contact": false, "as_printed": false, "material":
/// "MATERIAL.json", "tool_mesh": {"file": "HEAD.stl", "unit_mm": 1}}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

/// A packing that was computed or read, with the parameters of the method.
struct Packed {
  SpherePacking packing;
  Parameters parameters;
};
/// Parameters; null if `method` is another method.
const Parameters* parameters_of(const SharedContactMethod& method);
std::optional<Packed> packed_by(const SharedContactMethod& method, const TissueVolume& tissue);

}  // namespace typodont::haptics::packing
