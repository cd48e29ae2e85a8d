// Readers for files of the model "packing". This module links neither HDF5 nor a mesh reader. So another module,
// which can read these files, registers its functions here.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/contract/sphere_packing.h"
#include "haptics/solid.h"

namespace typodont::haptics {

using PackingLoader = std::function<SpherePacking(const std::filesystem::path&)>;

/// Registers a loader before main(). Declare it at namespace scope:
///   const PackingLoaderRegistration registration{session::load_packing};
struct PackingLoaderRegistration {
  explicit PackingLoaderRegistration(PackingLoader loader);
};

/// Reads a closed mesh as a tool's head. `unit`: m per unit of the file.
using ToolMeshReader = std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)>;

/// Registers a reader before main(). Declare it at namespace scope:
///   const ToolMeshReaderRegistration registration{haptics::read_mesh_solid};
struct ToolMeshReaderRegistration {
  explicit ToolMeshReaderRegistration(ToolMeshReader reader);
};

}  // namespace typodont::haptics
