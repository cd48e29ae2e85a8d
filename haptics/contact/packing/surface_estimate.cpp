#include "haptics/contact/packing/surface_estimate.h"

#include "engine/base/units.h"

namespace typodont::haptics::packing {

void OverlapSum::add(const dvec3& c, int i, double v) noexcept {
  const auto label = static_cast<std::size_t>(tissue_.tissue(i));
  const dvec3 off = c - tissue_.tree().center(i);
  const double d = glm::length(off), rho = density_[label] * tissue_.hardness(i);
  if (d > 0) normal_ += off / d * v * rho;
  sum_.share[label] += v;
  sum_.hardness[label] += v * tissue_.hardness(i);
  sum_.volume += v;
  weighted_ += v * rho;
}

SurfaceEstimate OverlapSum::estimate() const noexcept {
  SurfaceEstimate e = sum_;
  if (const double length = glm::length(normal_); length > 0) e.n_W = normal_ / length;
  if (e.volume > 0) {
    for (std::size_t t = 0; t < kTissueCount; ++t) {
      if (e.share[t] > 0) e.hardness[t] /= e.share[t];
      e.share[t] /= e.volume;
    }
    e.normalised = weighted_ / e.volume;
    e.density = weighted_ / kCubicMillimetre;
  }
  return e;
}

namespace {

/// Computes the estimate. near(t, c, r) must write the indices of the tissue's spheres within the distance r of c, the
/// centre of tool sphere t, to `scratch`, in the tree's order, and return their number.
template <class Near>
SurfaceEstimate estimated(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP, const dvec3& p_WC,
                          double epsilon, const PerTissue& density, std::span<int> scratch, Near&& near) noexcept {
  OverlapSum sum(tissue, density);
  for (std::size_t t = 0; t < tool.head; ++t) {
    const dvec3 c = X_WP * tool.center_T[t];
    if (glm::distance(c, p_WC) - tool.radius[t] > epsilon) continue;
    const double r = tool.radius[t] + epsilon;
    const std::size_t found = std::min(near(t, c, r), scratch.size());
    for (std::size_t k = 0; k < found; ++k) {
      const int i = scratch[k];
      const double d = glm::length(c - tissue.tree().center(i));
      sum.add(c, i, lens_volume(r, tissue.tree().radius(i), d));
    }
  }
  return sum.estimate();
}

}  // namespace

SurfaceEstimate estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                 const dvec3& p_WC, double epsilon, const PerTissue& density,
                                 std::span<int> scratch) noexcept {
  return estimated(tissue, tool, X_WP, p_WC, epsilon, density, scratch,
                   [&](std::size_t, const dvec3& c, double r) { return tissue.tree().near_segment(c, c, r, scratch); });
}

SurfaceEstimate estimate_surface(const SphereTissue& tissue, SphereProxy& proxy, const dvec3& p_WC, double epsilon,
                                 const PerTissue& density, std::span<int> scratch) noexcept {
  return estimated(
      tissue, proxy.tool(), proxy.pose(), p_WC, epsilon, density, scratch,
      [&](std::size_t t, const dvec3&, double) { return proxy.near_here(tissue.tree(), t, epsilon, scratch); });
}

}  // namespace typodont::haptics::packing
