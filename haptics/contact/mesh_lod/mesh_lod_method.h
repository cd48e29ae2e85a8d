// The contact method "mesh_lod": contact with a mesh in levels of detail (S3 in docs/papers.md).
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::mesh_lod {

inline constexpr std::string_view kName = "mesh_lod";

/// Reads the parameters, for example {"vertices": 143865, "levels": [33140, 13306, 7443], "switch_mm_s": [30, 120],
/// "hysteresis": 0.1, "mapping": true, "ramp_N_per_s": 5, "wall_limit_N": 0.5, "as_printed": false}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::mesh_lod
