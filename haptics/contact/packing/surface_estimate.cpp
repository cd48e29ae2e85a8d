#include "haptics/contact/packing/surface_estimate.h"

#include <algorithm>

#include "engine/base/dispatch.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/sphere_lanes.h"

namespace typodont::haptics::packing {

void OverlapSum::add(const dvec3& c, Place place, double v) noexcept {
  const dvec3 off = c - tissue_.tree().center(place);
  const double d = glm::length(off);
  add(place, d > 0 ? off / d : dvec3(0), v);
}

void OverlapSum::add(Place place, const dvec3& n, double v) noexcept {
  const auto label = static_cast<std::size_t>(tissue_.tissue(place));
  const double hardness = tissue_.hardness(place), rho = density_[label] * hardness;
  normal_ += n * v * rho;
  sum_.fraction[label] += v;
  sum_.hardness[label] += v * hardness;
  sum_.volume += v;
  weighted_ += v * rho;
}

SurfaceEstimate OverlapSum::estimate() const noexcept {
  SurfaceEstimate e = sum_;
  if (const double length = glm::length(normal_); length > 0) e.n_W = normal_ / length;
  if (e.volume > 0) {
    for (std::size_t t = 0; t < kTissueCount; ++t) {
      if (e.fraction[t] > 0) e.hardness[t] /= e.fraction[t];
      e.fraction[t] /= e.volume;
    }
    e.normalised = weighted_ / e.volume;
    e.density = weighted_ / kCubicMillimetre;
  }
  return e;
}

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

/// near(t, c, r) must write to `scratch` the tissue spheres within r of c, the centre of tool sphere t, in the tree's
/// order, and return their number.
template <class Near>
SurfaceEstimate estimated(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP, const dvec3& p_WC,
                          double epsilon, const PerTissue& density, std::span<Place> scratch, Near&& near) noexcept {
  OverlapSum sum(tissue, density);
  for (std::size_t t = 0; t < tool.head; ++t) {
    const dvec3 c = X_WP * tool.center_T[t];
    if (glm::distance(c, p_WC) - tool.radius[t] > epsilon) continue;
    const double r = tool.radius[t] + epsilon;
    const std::size_t found = std::min(near(t, c, r), scratch.size());
    for (std::size_t k = 0; k < found; k += SphereTree::kLeafSize) {
      const std::span<const Place> some = scratch.subspan(k, std::min(found - k, SphereTree::kLeafSize));
      Overlaps overlaps;
      overlaps_of(tissue.tree().lanes_of(some), c, r, overlaps);
      for (std::size_t j = 0; j < some.size(); ++j) {
        if (!(overlaps.volume[j] > 0)) continue;
        sum.add(some[j], {overlaps.n[0][j], overlaps.n[1][j], overlaps.n[2][j]}, overlaps.volume[j]);
      }
    }
  }
  return sum.estimate();
}

}  // namespace

SurfaceEstimate estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                 const dvec3& p_WC, double epsilon, const PerTissue& density,
                                 std::span<Place> scratch) noexcept {
  return estimated(tissue, tool, X_WP, p_WC, epsilon, density, scratch,
                   [&](std::size_t, const dvec3& c, double r) { return tissue.tree().near_segment(c, c, r, scratch); });
}

SurfaceEstimate estimate_surface(const SphereTissue& tissue, SphereProxy& proxy, const dvec3& p_WC, double epsilon,
                                 const PerTissue& density, std::span<Place> scratch) noexcept {
  return estimated(
      tissue, proxy.tool(), proxy.pose(), p_WC, epsilon, density, scratch,
      [&](std::size_t t, const dvec3&, double) { return proxy.near_here(tissue.tree(), t, epsilon, scratch); });
}

}  // namespace typodont::haptics::packing
