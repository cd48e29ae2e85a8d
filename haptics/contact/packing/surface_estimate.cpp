#include "haptics/contact/packing/surface_estimate.h"

#include "engine/base/units.h"

namespace typodont::haptics::packing {

SurfaceEstimate estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                 const dvec3& p_WC, double epsilon, const PerTissue& density,
                                 std::span<int> scratch) noexcept {
  SurfaceEstimate e;
  dvec3 sum(0);
  double weighted = 0;  // m³
  for (std::size_t t = 0; t < tool.head; ++t) {
    const dvec3 c = X_WP * tool.center_T[t];
    if (glm::distance(c, p_WC) - tool.radius[t] > epsilon) continue;
    const double r = tool.radius[t] + epsilon;
    const std::size_t found = std::min(tissue.tree().near_segment(c, c, r, scratch), scratch.size());
    for (std::size_t k = 0; k < found; ++k) {
      const int i = scratch[k];
      const auto label = static_cast<std::size_t>(tissue.tissue(i));
      const dvec3 off = c - tissue.tree().center(i);
      const double d = glm::length(off), v = lens_volume(r, tissue.tree().radius(i), d);
      const double rho = density[label] * tissue.hardness(i);
      if (d > 0) sum += off / d * v * rho;
      e.share[label] += v;
      e.hardness[label] += v * tissue.hardness(i);
      e.volume += v;
      weighted += v * rho;
    }
  }
  if (const double length = glm::length(sum); length > 0) e.n_W = sum / length;
  if (e.volume > 0) {
    for (std::size_t t = 0; t < kTissueCount; ++t) {
      if (e.share[t] > 0) e.hardness[t] /= e.share[t];
      e.share[t] /= e.volume;
    }
    e.normalised = weighted / e.volume;
    e.density = weighted / kCubicMillimetre;
  }
  return e;
}

}  // namespace typodont::haptics::packing
