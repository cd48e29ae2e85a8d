// Packings of spheres for the contact model "packing": making, drawing, and the readers of their files.
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
  // shifts the grid of candidates: another packing
  std::uint64_t seed = 1;
  /// m, largest, because a sphere is the least that a cut removes: unlimited, a molar's first would be as wide as its
  /// crown. 0: kDefaultMaxRadius times the radius of `spheres` equal ones with the tissue's volume.
  double max_radius = 0;
  /// 0 to 1; may throw to stop.
  std::function<void(double fraction)> progress;

  static constexpr std::size_t kMaxSpheres = 4'000'000;
  static constexpr double kDefaultMaxRadius = 2.0;
};

/// Each in one tissue, none overlapping (Weller & Zachmann 2010, "ProtoSphere", with a grid for random prototypes).
/// Deterministic; `tissue_hash` 0. Throws Error if empty or out of range.
SpherePacking pack_spheres(const DenseTissue& tissue, const PackOptions& options);

/// `tissue_hash` is the volume's hash.
SpherePacking pack_spheres(const TissueVolume& volume, const PackOptions& options);

/// A sphere of the tissue in its present state.
struct ShownSphere {
  dvec3 p_W{0};        // m, centre
  double radius = 0;   // m
  double density = 0;  // relative to dentin; decides the cutting speed
};

/// All that remain; empty with another method. Carver thread.
std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings);

// The files need HDF5 or a mesh reader, which this module does not use: a module that can read them registers its
// functions.

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
