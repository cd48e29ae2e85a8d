// A closed mesh as solid with exact distance. Set-up only.
#pragma once

#include <filesystem>
#include <memory>

#include "haptics/solid.h"

namespace typodont::haptics {

/// `unit`: m per unit. Throws Error, also if not closed.
std::unique_ptr<Solid> read_mesh_solid(const std::filesystem::path& file, double unit);

}  // namespace typodont::haptics
