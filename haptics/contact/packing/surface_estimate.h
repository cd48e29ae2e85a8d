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

/// Computes eq. 2 and 3 of paper S2 at the proxy's pose, with the head's spheres enlarged by `epsilon` (m). `p_WC`:
/// contact point. `density`: of each tissue, multiplied here by each sphere's hardness; 0: no resistance. `scratch`:
/// buffer for tissue spheres near the head.
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
