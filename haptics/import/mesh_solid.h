// A closed mesh as a solid with exact distance. For set-up only.
#pragma once

#include <filesystem>
#include <memory>

#include "haptics/solid.h"

namespace typodont::haptics {

/// `unit`: m per unit of the file. Throws Error, also if the mesh is not closed.
std::unique_ptr<Solid> read_mesh_solid(const std::filesystem::path& file, double unit);

}  // namespace typodont::haptics
