#include "haptics/contact/packing/surface_estimate.h"

#include <algorithm>

#include "engine/base/dispatch.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/sphere_lanes.h"

namespace typodont::haptics::packing {

namespace {

/// Overlaps of eight tissue spheres with one ball.
struct Overlaps {
  double volume[SphereTree::kLeafSize];
  double n[3][SphereTree::kLeafSize];  // unit vectors from each sphere to the ball
};

/// Computes overlaps with a ball of radius `r` at `c`.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void overlaps_of(const SphereTree::Leaf& spheres, const dvec3& c, double r, Overlaps& overlaps) {
  D8 x, y, z, radius, volume;
  read_lanes(x, spheres.x), read_lanes(y, spheres.y), read_lanes(z, spheres.z), read_lanes(radius, spheres.r);
  x = c.x - x, y = c.y - y, z = c.z - z;
  D8 d = x * x + y * y + z * z;
  take_root(d);
  lens_volumes(D8{} + r, radius, d, volume);
  const L8 apart = d > D8{};
  write_lanes(overlaps.volume, volume);
  write_lanes(overlaps.n[0], apart ? x / d : D8{});
  write_lanes(overlaps.n[1], apart ? y / d : D8{});
  write_lanes(overlaps.n[2], apart ? z / d : D8{});
}

}  // namespace

SurfaceEstimate estimate_surface(const SphereTissue& tissue, SphereProxy& proxy, const dvec3& p_WC, double epsilon,
                                 const PerTissue& density, std::span<Place> scratch) noexcept {
  const ToolSpheres& tool = proxy.tool();
  SurfaceEstimate e;
  dvec3 normal(0);      // m³, sum of overlap × density × direction from tissue to tool
  double weighted = 0;  // m³, sum of overlap × density
  for (std::size_t t = 0; t < tool.head; ++t) {
    const dvec3 c = proxy.pose() * tool.center_T[t];
    if (glm::distance(c, p_WC) - tool.radius[t] > epsilon) continue;
    const std::size_t found = std::min(proxy.near_here(tissue.tree(), t, epsilon, scratch), scratch.size());
    for (std::size_t k = 0; k < found; k += SphereTree::kLeafSize) {
      const std::span<const Place> some = scratch.subspan(k, std::min(found - k, SphereTree::kLeafSize));
      Overlaps overlaps;
      overlaps_of(tissue.tree().lanes_of(some), c, tool.radius[t] + epsilon, overlaps);
      for (std::size_t j = 0; j < some.size(); ++j) {
        const double v = overlaps.volume[j];
        if (!(v > 0)) continue;
        const auto label = static_cast<std::size_t>(tissue.tissue(some[j]));
        const double hardness = tissue.hardness(some[j]), rho = density[label] * hardness;
        normal += dvec3(overlaps.n[0][j], overlaps.n[1][j], overlaps.n[2][j]) * v * rho;
        e.fraction[label] += v;
        e.hardness[label] += v * hardness;
        e.volume += v;
        weighted += v * rho;
      }
    }
  }
  if (const double length = glm::length(normal); length > 0) e.n_W = normal / length;
  if (e.volume > 0) {
    for (std::size_t t = 0; t < kTissueCount; ++t) {
      if (e.fraction[t] > 0) e.hardness[t] /= e.fraction[t];
      e.fraction[t] /= e.volume;
    }
    e.normalised = weighted / e.volume;
    e.density = weighted / kCubicMillimetre;
  }
  return e;
}

}  // namespace typodont::haptics::packing
