// Fills a tissue with spheres that do not overlap, larger ones first. Set-up time.
#pragma once

#include <cstdint>
#include <functional>

#include "engine/contract/sphere_packing.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

struct PackOptions {
  std::size_t spheres = 36000;  // 1 … kMaxSpheres
  std::uint64_t seed = 1;       // shifts the grid on which places are looked for: another packing of the same kind
  /// m, no sphere is larger; 0: kDefaultMaxRadius times the radius at which `spheres` equal spheres have the tissue's
  /// volume. A sphere is the least that a cut can take, so without a limit the first sphere of a molar would be a
  /// crown's width.
  double max_radius = 0;
  /// Told the share done, 0 to 1; stops the work by throwing.
  std::function<void(double share)> progress;

  static constexpr std::size_t kMaxSpheres = 4'000'000;
  static constexpr double kDefaultMaxRadius = 2.0;
};

/// Inner spheres on the field's own distances: each lies inside one tissue and touches no other sphere (Weller &
/// Zachmann 2010, "ProtoSphere", with a grid in place of random prototypes). Equal input gives equal bits. Leaves
/// `tissue_hash` 0. Throws Error where the tissue is empty or the options are out of range.
SpherePacking pack_spheres(const DenseTissue& tissue, const PackOptions& options);

/// Of all the tissue in a volume; `tissue_hash` is the volume's.
SpherePacking pack_spheres(const TissueVolume& volume, const PackOptions& options);

}  // namespace typodont::haptics
