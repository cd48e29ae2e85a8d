// Files of the model "packing" that this module cannot read: it links no HDF5 and no reader of meshes, so whoever does
// says how they are read.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/contract/sphere_packing.h"
#include "haptics/solid.h"

namespace typodont::haptics {

using PackingLoader = std::function<SpherePacking(const std::filesystem::path&)>;

/// Before main(), at namespace scope: const PackingLoaderRegistration registration{session::load_packing};
struct PackingLoaderRegistration {
  explicit PackingLoaderRegistration(PackingLoader loader);
};

/// A closed mesh as a tool's head; `unit` in m.
using ToolMeshReader = std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)>;

/// Before main(), at namespace scope: const ToolMeshReaderRegistration registration{haptics::read_mesh_solid};
struct ToolMeshReaderRegistration {
  explicit ToolMeshReaderRegistration(ToolMeshReader reader);
};

}  // namespace typodont::haptics
