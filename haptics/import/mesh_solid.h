// A closed triangle mesh as a solid: the distance to its triangles, exactly. Set-up time.
#pragma once

#include <filesystem>
#include <memory>

#include "haptics/solid.h"

namespace typodont::haptics {

/// Reads STL, PLY or OBJ; `unit` in m per unit of the file. Throws Error, also when the surface is not closed.
std::unique_ptr<Solid> read_mesh_solid(const std::filesystem::path& file, double unit);

}  // namespace typodont::haptics
