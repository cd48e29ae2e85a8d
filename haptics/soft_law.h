// Properties of soft tissue, and the data that a picture of the tissue needs. haptics/soft_tissue.h contains the
// simulation.
#pragma once

#include <cstdint>

#include "engine/base/clock.h"
#include "engine/base/pose.h"

namespace typodont::haptics {

/// Material and geometry of the soft tissue. SI units. haptics/soft/README.md names the sources of the defaults.
struct SoftLaw {
  double elastic_modulus = 1e6;  // Pa
  // m, thickness of the soft layer on bone; where the tissue is thinner, its own thickness is used
  double thickness = 2e-3;
  double return_time = 0.2;         // s, time constant with which the tissue returns after release
  double friction = 0.1;            // Coulomb coefficient of a tool that does not rotate
  double specific_energy = 0.3e9;   // J/m³, energy that a bur needs to remove the tissue
  double spacing = 0.35e-3;         // m, distance between the simulated points
  double bleeding_depth = 0.25e-3;  // m, depth of a cut from which it bleeds
  double blood_radius = 2.5e-3;     // m, final radius of the wet patch around a wound
  double blood_time = 8;            // s, time constant with which the patch grows
};

/// A place where a cut of the soft tissue bleeds.
struct SoftWound {
  Nanos t = 0;   // time at which it began to bleed
  dvec3 p_W{0};  // m
};
/// Radius in m of the wet patch around a wound, `age` seconds after the wound began to bleed.
double blood_radius(const SoftLaw& law, double age) noexcept;

/// New state of one point, for a picture.
struct SoftMove {
  std::uint32_t point = 0;  // index in SoftSurface::points()
  float inward = 0;         // m, displacement against the point's normal, including the cut
};

}  // namespace typodont::haptics
