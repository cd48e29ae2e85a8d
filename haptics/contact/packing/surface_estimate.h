// Tissue in contact and its cutting speed (S2, pass 2, eq. 2 to 5). Pure; servo thread.
#pragma once

#include <span>

#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

struct SurfaceEstimate {
  dvec3 n_W{0};       // out of the tissue (S2, eq. 2); zero: none
  double volume = 0;  // m³, all overlaps
  // ρ of S2, eq. 3, with mm³; grows with the contact, which then cuts more slowly
  double density = 0;
  double normalised = 0;  // ρ̂ of S2, eq. 3; any contact size
  PerTissue fraction{};   // of `volume`; sum 1
  PerTissue hardness{};   // of spheres in contact (SphereTissue::hardness)
};

/// S2, eq. 2 and 3. The pairs' order affects the last bits.
class OverlapSum {
 public:
  OverlapSum(const SphereTissue& tissue, const PerTissue& density) : tissue_(tissue), density_(density) {}
  /// `v`: m³, tool sphere at `c`, tissue sphere at `place`.
  void add(const dvec3& c, Place place, double v) noexcept;
  /// `n`: tissue to tool; zero: same centre.
  void add(Place place, const dvec3& n, double v) noexcept;
  SurfaceEstimate estimate() const noexcept;

 private:
  const SphereTissue& tissue_;
  const PerTissue& density_;
  SurfaceEstimate sum_;
  dvec3 normal_{0};
  double weighted_ = 0;  // m³, sum of overlap × density
};

/// S2, eq. 2, 3, with the head's spheres enlarged by `epsilon` (m). `density` per tissue, times each sphere's hardness;
/// 0: no resistance. `scratch`: places.
SurfaceEstimate estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                 const dvec3& p_WC, double epsilon, const PerTissue& density,
                                 std::span<Place> scratch) noexcept;

/// Same bits, by `proxy`'s near lists.
SurfaceEstimate estimate_surface(const SphereTissue& tissue, SphereProxy& proxy, const dvec3& p_WC, double epsilon,
                                 const PerTissue& density, std::span<Place> scratch) noexcept;

/// S2, eq. 4, m/s; `free_speed` at density zero.
inline double cutting_speed(double base_speed, double density, double free_speed) noexcept {
  return density * free_speed > base_speed ? base_speed / density : free_speed;
}

/// S2, eq. 5, corrected (m · v_d / Δt is no length): m in `dt` s, towards a point `left` m away.
inline double cutting_step(double speed, double dt, double left) noexcept {
  return std::min(speed * dt, left);
}

}  // namespace typodont::haptics::packing
