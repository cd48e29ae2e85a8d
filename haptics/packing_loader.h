// Packings from files: this module links no HDF5, so whoever does says how they are read.
#pragma once

#include <filesystem>
#include <functional>

#include "engine/contract/sphere_packing.h"

namespace typodont::haptics {

using PackingLoader = std::function<SpherePacking(const std::filesystem::path&)>;

/// Before main(), at namespace scope: const PackingLoaderRegistration registration{session::load_packing};
struct PackingLoaderRegistration {
  explicit PackingLoaderRegistration(PackingLoader loader);
};

}  // namespace typodont::haptics
