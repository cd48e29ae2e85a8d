// Packs a tissue with spheres that do not overlap, the largest first. Slow: not for the servo.
#pragma once

#include <cstdint>
#include <functional>

#include "engine/contract/sphere_packing.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

struct PackOptions {
  std::size_t spheres = 36000;  // number of spheres, 1 to kMaxSpheres
  // random seed; it shifts the grid of candidate positions, so another seed gives another packing
  std::uint64_t seed = 1;
  /// Largest radius of a sphere in m. A sphere is the smallest unit that a cut can remove; without a limit, the first
  /// sphere of a molar would be as wide as its crown. 0: the limit is kDefaultMaxRadius times the radius of `spheres`
  /// equal spheres that together have the tissue's volume.
  double max_radius = 0;
  /// Called with the completed fraction 0 to 1. To stop the work, this function throws an exception.
  std::function<void(double fraction)> progress;

  static constexpr std::size_t kMaxSpheres = 4'000'000;
  static constexpr double kDefaultMaxRadius = 2.0;
};

/// Packs spheres inside the distance field. Each sphere lies inside one tissue and overlaps no other sphere (Weller &
/// Zachmann 2010, "ProtoSphere", but with a grid instead of random prototypes). The result is deterministic; its
/// `tissue_hash` is 0. Throws Error if the tissue is empty or an option is out of range.
SpherePacking pack_spheres(const DenseTissue& tissue, const PackOptions& options);

/// Packs the whole tissue of a volume. The `tissue_hash` of the result is the hash of the volume.
SpherePacking pack_spheres(const TissueVolume& volume, const PackOptions& options);

}  // namespace typodont::haptics
