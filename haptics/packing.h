// Spheres without overlap, largest first. Slow: not for the servo.
#pragma once

#include <cstdint>
#include <functional>

#include "engine/contract/sphere_packing.h"
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

}  // namespace typodont::haptics
