// Fills a tissue with spheres that do not overlap, larger ones first. Set-up time.
#pragma once

#include <cstdint>
#include <functional>

#include "engine/contract/sphere_packing.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

struct PackOptions {
  std::size_t spheres = 36000;  // number of spheres, 1 to kMaxSpheres
  std::uint64_t seed = 1;       // shifts the grid of candidate positions, which gives another packing of the same kind
  /// m, limit of the radius; 0: kDefaultMaxRadius times the radius at which `spheres` equal spheres have the tissue's
  /// volume. A sphere is the smallest unit of a cut, and without a limit the first sphere of a molar would be as wide
  /// as its crown.
  double max_radius = 0;
  /// Called with the completed fraction, 0 to 1; stops the work by throwing an exception.
  std::function<void(double share)> progress;

  static constexpr std::size_t kMaxSpheres = 4'000'000;
  static constexpr double kDefaultMaxRadius = 2.0;
};

/// Packs spheres inside the distance field: each lies inside one tissue and overlaps no other sphere (Weller & Zachmann
/// 2010, "ProtoSphere", with a grid instead of random prototypes). Equal input gives equal bits. `tissue_hash` of the
/// result is 0. Throws Error if the tissue is empty or the options are out of range.
SpherePacking pack_spheres(const DenseTissue& tissue, const PackOptions& options);

/// Packs all tissue of a volume; `tissue_hash` is the volume's hash.
SpherePacking pack_spheres(const TissueVolume& volume, const PackOptions& options);

}  // namespace typodont::haptics
