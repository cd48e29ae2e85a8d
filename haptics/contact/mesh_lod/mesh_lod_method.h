// The contact method "mesh_lod": contact with a mesh in levels of detail (paper S3 in docs/papers.md).
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::mesh_lod {

inline constexpr std::string_view kName = "mesh_lod";

/// Reads the parameters, and creates the method with them. Throws Error.
SharedContactMethod read(Keys& keys);

}  // namespace typodont::haptics::mesh_lod
