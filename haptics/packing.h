// Packings of spheres for the contact model "packing": creation, drawing, and readers of their files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "engine/contract/sphere_packing.h"
#include "haptics/carver.h"
#include "haptics/solid.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

struct PackOptions {
  std::size_t spheres = 36000;  // number of spheres, 1 to kMaxSpheres
  // Determines the offset of the grid of candidate centres; another seed gives another packing.
  std::uint64_t seed = 1;
  /// Largest radius of a sphere, m; 0: kDefaultMaxRadius times the radius of `spheres` equal spheres with the tissue's
  /// volume. Without this limit, the first sphere in a molar would be as wide as its crown.
  double max_radius = 0;
  /// Receives the progress, 0 to 1; may throw to stop the work.
  std::function<void(double fraction)> progress;

  static constexpr std::size_t kMaxSpheres = 4'000'000;
  static constexpr double kDefaultMaxRadius = 2.0;
};

/// Packs spheres that do not overlap, each inside one tissue (Weller & Zachmann 2010, "ProtoSphere", with a grid
/// instead of random prototypes). Deterministic; `tissue_hash` is 0. Throws Error for empty tissue or options out of
/// range.
SpherePacking pack_spheres(const DenseTissue& tissue, const PackOptions& options);

/// Packs the tissue of a volume; sets `tissue_hash` to the volume's hash.
SpherePacking pack_spheres(const TissueVolume& volume, const PackOptions& options);

/// A sphere of the tissue's current state, for drawing.
struct ShownSphere {
  dvec3 p_W{0};        // m, centre of the sphere
  double radius = 0;   // m, radius of the sphere
  double density = 0;  // density relative to that of dentin; determines the cutting speed
};

/// Returns all remaining spheres; none with another contact method. Carver thread only.
std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings);

// Reader of a packing's file, which needs HDF5. This module does not use HDF5, so another module registers the reader.

using PackingLoader = std::function<SpherePacking(const std::filesystem::path&)>;

/// Registers, before main(), a function that loads packings. Declare an object at namespace scope:
///   const PackingLoaderRegistration registration{session::load_packing};
struct PackingLoaderRegistration {
  explicit PackingLoaderRegistration(PackingLoader loader);
};

/// Reads a closed mesh as the head of a tool. `unit`: metres per unit of the file.
using ToolMeshReader = std::function<std::unique_ptr<Solid>(const std::filesystem::path& file, double unit)>;

/// Registers, before main(), a function that reads meshes. Declare an object at namespace scope:
///   const ToolMeshReaderRegistration registration{haptics::read_mesh_solid};
struct ToolMeshReaderRegistration {
  explicit ToolMeshReaderRegistration(ToolMeshReader reader);
};

}  // namespace typodont::haptics
