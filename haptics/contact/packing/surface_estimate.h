// The tissue in contact with the tool, and its cutting speed: paper S2, pass 2 and eq. 2 to 5. Pure functions. Servo
// thread, noexcept.
#pragma once

#include <span>

#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

struct SurfaceEstimate {
  dvec3 n_W{0};           // unit normal, pointing out of the tissue (eq. 2); zero if no tissue is near
  double volume = 0;      // m³, sum of all overlaps
  double density = 0;     // density ρ of eq. 3 with the volume in mm³; a larger contact makes cutting slower
  double normalised = 0;  // normalised density ρ̂ of eq. 3; depends only on the material, not on the contact area
  PerTissue share{};      // fraction of the volume that each tissue has; the sum is 1
  PerTissue hardness{};   // for each tissue: mean of its spheres' SphereTissue::hardness()
};

/// Sums the overlaps of eq. 2 and 3 over pairs of spheres. The order affects the last bits.
class OverlapSum {
 public:
  OverlapSum(const SphereTissue& tissue, const PerTissue& density) : tissue_(tissue), density_(density) {}
  /// Adds an overlap of the volume `v` (m³) between the tool's sphere at `c` and the tissue's sphere `i`.
  void add(const dvec3& c, int i, double v) noexcept;
  SurfaceEstimate estimate() const noexcept;

 private:
  const SphereTissue& tissue_;
  const PerTissue& density_;
  SurfaceEstimate sum_;
  dvec3 normal_{0};
  double weighted_ = 0;  // m³
};

/// Sums the overlaps (eq. 2, 3) between the tissue and the head's spheres that reach within `epsilon` of the contact.
/// These spheres are enlarged by `epsilon`. `density`: density of each tissue, 0 for no resistance; it is multiplied
/// by a sphere's hardness. `scratch`: buffer for the indices of the spheres near one tool sphere.
SurfaceEstimate estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                 const dvec3& p_WC, double epsilon, const PerTissue& density,
                                 std::span<int> scratch) noexcept;

/// Same with the proxy's own lists of near spheres; gives the same bits.
SurfaceEstimate estimate_surface(const SphereTissue& tissue, SphereProxy& proxy, const dvec3& p_WC, double epsilon,
                                 const PerTissue& density, std::span<int> scratch) noexcept;

/// Eq. 4: cutting speed in m/s. At zero density nothing holds the tool, and the speed is `free_speed`.
inline double cutting_speed(double base_speed, double density, double free_speed) noexcept {
  return density * free_speed > base_speed ? base_speed / density : free_speed;
}

/// Eq. 5, corrected: the tool's displacement in `dt` seconds toward a point at the distance `left` (m). (The printed
/// formula m · v_d / Δt is not a length.)
inline double cutting_step(double speed, double dt, double left) noexcept {
  return std::min(speed * dt, left);
}

}  // namespace typodont::haptics::packing
