// Estimates which tissue is in contact with the tool, and computes the cutting speed in this tissue (paper S2, pass 2
// and eq. 2 to 5). Pure functions. Servo thread, noexcept.
#pragma once

#include <span>

#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/sphere_tissue.h"

namespace typodont::haptics::packing {

struct SurfaceEstimate {
  dvec3 n_W{0};       // unit normal, pointing out of the tissue (paper S2, eq. 2); zero if there is no tissue nearby
  double volume = 0;  // m³, sum of the overlaps between spheres of the tool and of the tissue
  // density ρ of eq. 3 in paper S2, computed with the volume in mm³; it grows with the contact volume, so a larger
  // contact cuts more slowly
  double density = 0;
  double normalised = 0;  // normalised density ρ̂ (paper S2, eq. 3); independent of the size of the contact
  PerTissue fraction{};   // for each tissue: fraction 0..1 of `volume` that belongs to it; the sum is 1
  PerTissue hardness{};   // for each tissue: mean hardness of its spheres in contact (SphereTissue::hardness)
};

/// Sums the overlaps of paper S2, eq. 2 and 3, over pairs of spheres. The order of the pairs affects the last bits.
class OverlapSum {
 public:
  OverlapSum(const SphereTissue& tissue, const PerTissue& density) : tissue_(tissue), density_(density) {}
  /// Adds an overlap of the volume `v` (m³) between the tool sphere with centre `c` and the tissue sphere
  /// at `place`.
  void add(const dvec3& c, Place place, double v) noexcept;
  /// Adds an overlap whose direction is known. `n`: unit vector from the tissue sphere to the tool sphere; zero if
  /// their centres coincide.
  void add(Place place, const dvec3& n, double v) noexcept;
  SurfaceEstimate estimate() const noexcept;

 private:
  const SphereTissue& tissue_;
  const PerTissue& density_;
  SurfaceEstimate sum_;
  dvec3 normal_{0};
  double weighted_ = 0;  // m³, sum of overlap × density
};

/// Sums the overlaps (paper S2, eq. 2, 3) between the tissue and the head's spheres near the contact, which are
/// enlarged by `epsilon` (m). `density`: density of each tissue; it is multiplied by the hardness of each sphere, and 0
/// means no resistance. `scratch`: buffer for the places (indices in the tree) of the spheres near one tool sphere.
SurfaceEstimate estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                 const dvec3& p_WC, double epsilon, const PerTissue& density,
                                 std::span<Place> scratch) noexcept;

/// Gives the same bits as the other estimate_surface(), but finds the tissue spheres without a search of the tree: it
/// reads the near lists of `proxy` (for each tool sphere, the tissue spheres near it).
SurfaceEstimate estimate_surface(const SphereTissue& tissue, SphereProxy& proxy, const dvec3& p_WC, double epsilon,
                                 const PerTissue& density, std::span<Place> scratch) noexcept;

/// Paper S2, eq. 4: returns the cutting speed in m/s. At density zero the tissue has no resistance, and the speed is
/// `free_speed`.
inline double cutting_speed(double base_speed, double density, double free_speed) noexcept {
  return density * free_speed > base_speed ? base_speed / density : free_speed;
}

/// Paper S2, eq. 5, corrected: returns the tool's displacement in `dt` seconds towards a point at the distance `left`
/// (m). (The formula m · v_d / Δt in the paper does not give a length.)
inline double cutting_step(double speed, double dt, double left) noexcept {
  return std::min(speed * dt, left);
}

}  // namespace typodont::haptics::packing
