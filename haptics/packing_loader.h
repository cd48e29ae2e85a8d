// Registration of file readers for the contact model "packing". The files need HDF5 or a mesh reader, which this module
// does not use. So a module that can read them registers its functions here.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/contract/sphere_packing.h"
#include "haptics/solid.h"

namespace typodont::haptics {

using PackingLoader = std::function<SpherePacking(const std::filesystem::path&)>;

/// Registers, before main(), a function that loads packings. Declare an object at namespace scope:
///   const PackingLoaderRegistration registration{session::load_packing};
struct PackingLoaderRegistration {
  explicit PackingLoaderRegistration(PackingLoader loader);
};

/// A closed mesh as a head. `unit`: metres per unit of the file.
using ToolMeshReader = std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)>;

/// Registers, before main(), a function that reads meshes. Declare an object at namespace scope:
///   const ToolMeshReaderRegistration registration{haptics::read_mesh_solid};
struct ToolMeshReaderRegistration {
  explicit ToolMeshReaderRegistration(ToolMeshReader reader);
};

}  // namespace typodont::haptics
