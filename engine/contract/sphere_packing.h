// From the packer to files and a contact model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/contract/tissue.h"

namespace typodont {

/// No overlaps, W. Sphere i: center[i], radius[i], tissue[i]. Larger ones first, exact to the resolution of the
/// packer's grid.
struct SpherePacking {
  std::vector<dvec3> center;   // m, frame W, centre of each sphere
  std::vector<double> radius;  // m, radius of each sphere; always above 0
  std::vector<Tissue> tissue;  // never kAir; each sphere lies in one tissue

  std::uint64_t seed = 0;         // seed of the packer's random numbers
  std::uint64_t tissue_hash = 0;  // TissueVolume::hash() of the tissue that was packed
  double max_radius = 0;          // m, that the packer could use
  double largest_hole = 0;        // m, largest sphere that still fits
  PerTissue solid_volume{};       // m³ per tissue; spheres fill part of it

  std::size_t size() const { return radius.size(); }
  /// m³ per tissue.
  PerTissue sphere_volume() const {
    PerTissue sum{};
    for (std::size_t i = 0; i < size(); ++i) {
      sum[static_cast<std::size_t>(tissue[i])] +=
          4.0 / 3.0 * 3.14159265358979323846 * radius[i] * radius[i] * radius[i];
    }
    return sum;
  }
  /// Of the tissue's volume, 0 to 1.
  double coverage() const {
    double spheres = 0, solid = 0;
    for (const double v : sphere_volume()) spheres += v;
    for (const double v : solid_volume) solid += v;
    return solid > 0 ? spheres / solid : 0;
  }
};

}  // namespace typodont
