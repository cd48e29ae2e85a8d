// Tissue as a packing of spheres, for a contact model and for files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/contract/tissue.h"

namespace typodont {

/// Spheres that do not overlap. Sphere i has center[i], radius[i] and tissue[i]. Large spheres come first. The order is
/// not exact, because the packer searches on a grid.
struct SpherePacking {
  std::vector<dvec3> center;   // m, frame W, centre of each sphere
  std::vector<double> radius;  // m, radius of each sphere; always above 0
  std::vector<Tissue> tissue;  // never kAir; each sphere lies in one tissue

  std::uint64_t seed = 0;         // seed of the packer's random numbers
  std::uint64_t tissue_hash = 0;  // TissueVolume::hash() of the tissue that was packed
  double max_radius = 0;          // m, largest radius that the packer was allowed to use
  double max_hole = 0;            // m, radius of the largest sphere that would still fit
  PerTissue solid_volume{};       // m³ for each tissue: volume of the tissue; the spheres fill a part of it

  std::size_t size() const { return radius.size(); }
  /// Volume of all spheres for each tissue, m³.
  PerTissue sphere_volume() const {
    PerTissue sum{};
    for (std::size_t i = 0; i < size(); ++i) {
      sum[static_cast<std::size_t>(tissue[i])] +=
          4.0 / 3.0 * 3.14159265358979323846 * radius[i] * radius[i] * radius[i];
    }
    return sum;
  }
  /// Fraction of the tissue's volume filled by spheres, 0 to 1.
  double coverage() const {
    double spheres = 0, solid = 0;
    for (const double v : sphere_volume()) spheres += v;
    for (const double v : solid_volume) solid += v;
    return solid > 0 ? spheres / solid : 0;
  }
};

}  // namespace typodont
