// A tissue as a packing of spheres: plain data that the packer creates, that files store and that the contact model
// reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/contract/tissue.h"

namespace typodont {

/// Spheres inside the tissue that do not overlap. Metres, frame W. Sphere i is center[i], radius[i], tissue[i]. They
/// are stored in the order of their placement, larger spheres first. This order is exact only to the resolution of the
/// packer's grid.
struct SpherePacking {
  std::vector<dvec3> center;   // m, W
  std::vector<double> radius;  // m, above 0
  std::vector<Tissue> tissue;  // never kAir; each sphere lies in one tissue

  std::uint64_t seed = 0;         // seed of the packer
  std::uint64_t tissue_hash = 0;  // TissueVolume::hash() of the packed tissue
  double max_radius = 0;          // m, largest radius that the packer was allowed to use
  double largest_hole = 0;        // m, radius of the largest sphere that still fits between the spheres
  PerTissue solid_volume{};       // m³, volume of the tissue; the spheres fill only a fraction of it

  std::size_t size() const { return radius.size(); }
  /// Volume of the spheres per tissue, m³.
  PerTissue sphere_volume() const {
    PerTissue sum{};
    for (std::size_t i = 0; i < size(); ++i) {
      sum[static_cast<std::size_t>(tissue[i])] +=
          4.0 / 3.0 * 3.14159265358979323846 * radius[i] * radius[i] * radius[i];
    }
    return sum;
  }
  /// Fraction of the tissue's volume that the spheres fill, 0 to 1.
  double coverage() const {
    double spheres = 0, solid = 0;
    for (const double v : sphere_volume()) spheres += v;
    for (const double v : solid_volume) solid += v;
    return solid > 0 ? spheres / solid : 0;
  }
};

}  // namespace typodont
