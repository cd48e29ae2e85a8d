// "packing": tissue and tool as spheres (S2).
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::packing {

inline constexpr std::string_view kName = "packing";

/// {"spheres": 36000, "seed": 1, "file": "P.h5", "tool_spheres": 60, "speed_mm_per_s": 1, "density": {"enamel": 1.5,
/// …}, "density_by_contact": false, "as_printed": false}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::packing
