// Uses a closed triangle mesh as a solid, with the exact distance to its triangles. The functions are called only at
// set-up, and allocate memory.
#pragma once

#include <filesystem>
#include <memory>

#include "haptics/solid.h"

namespace typodont::haptics {

/// Reads a mesh file (STL, PLY or OBJ). `unit` is the length in m of one unit of the file. Throws Error, also if the
/// surface is not closed.
std::unique_ptr<Solid> read_mesh_solid(const std::filesystem::path& file, double unit);

}  // namespace typodont::haptics
