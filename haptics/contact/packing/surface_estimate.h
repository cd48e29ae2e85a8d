// Estimates the tissue in contact and its cutting speed (paper S2 in docs/papers.md, eq. 2 to 5). Pure functions;
// servo thread only.
#pragma once

#include <span>

#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

struct SurfaceEstimate {
  dvec3 n_W{0};       // normal out of tissue (paper S2, eq. 2); zero: no overlap
  double volume = 0;  // m³, sum of all overlaps
  // mm³, sum of overlap × density (ρ of paper S2, eq. 3); a larger contact is therefore cut more slowly
  double density = 0;
  double normalised = 0;  // mean density of the contact (ρ̂ of paper S2, eq. 3)
  PerTissue fraction{};   // fraction of each tissue in `volume`; the sum is 1
  PerTissue hardness{};   // mean hardness of each tissue's spheres in contact (SphereTissue::hardness)
};

/// Adds the overlaps of pairs of spheres (paper S2, eq. 2 and 3). The order of the pairs changes the rounding.
class OverlapSum {
 public:
  OverlapSum(const SphereTissue& tissue, const PerTissue& density) : tissue_(tissue), density_(density) {}
  /// Adds the overlap `v` (m³) of the tool sphere at `c` with the tissue sphere at `place`.
  void add(const dvec3& c, Place place, double v) noexcept;
  /// Adds an overlap `v` (m³) with the direction `n` from tissue to tool; `n` is zero if both have the same centre.
  void add(Place place, const dvec3& n, double v) noexcept;
  SurfaceEstimate estimate() const noexcept;

 private:
  const SphereTissue& tissue_;
  const PerTissue& density_;
  SurfaceEstimate sum_;
  dvec3 normal_{0};
  double weighted_ = 0;  // m³, sum of overlap (m³) × density (no unit)
};

/// Computes eq. 2 and 3 of paper S2, with the head's spheres enlarged by `epsilon` (m). `density`: of each tissue,
/// multiplied here by each sphere's hardness; 0: no resistance. `scratch`: buffer for tissue spheres near the head.
SurfaceEstimate estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                 const dvec3& p_WC, double epsilon, const PerTissue& density,
                                 std::span<Place> scratch) noexcept;

/// Like estimate_surface() above, bit-identical, but searches the proxy's lists of near spheres where they suffice.
SurfaceEstimate estimate_surface(const SphereTissue& tissue, SphereProxy& proxy, const dvec3& p_WC, double epsilon,
                                 const PerTissue& density, std::span<Place> scratch) noexcept;

/// Cutting speed in m/s (paper S2, eq. 4); `free_speed` at density zero.
inline double cutting_speed(double base_speed, double density, double free_speed) noexcept {
  return density * free_speed > base_speed ? base_speed / density : free_speed;
}

/// Step of the cut in m during `dt` s, to a point `left` m away (S2, eq. 5; its printed m · v_d / Δt is not a length).
inline double cutting_step(double speed, double dt, double left) noexcept {
  return std::min(speed * dt, left);
}

}  // namespace typodont::haptics::packing
