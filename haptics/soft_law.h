// Soft tissue's properties, and data for the renderer (simulation: haptics/soft_tissue.h).
#pragma once

#include <cstdint>

#include "engine/base/clock.h"
#include "engine/base/pose.h"

namespace typodont::haptics {

/// SI; sources: haptics/soft/README.md.
struct SoftLaw {
  double elastic_modulus = 1e6;  // Pa, Young's modulus
  // m; thinner tissue has its own
  double thickness = 2e-3;
  double return_time = 0.2;         // s, of recovery after release
  double friction = 0.1;            // Coulomb, for a tool that does not rotate
  double specific_energy = 0.3e9;   // J/m³, for a bur
  double spacing = 0.35e-3;         // m, distance between the simulated points
  double bleeding_depth = 0.25e-3;  // m, deeper cuts bleed
  double blood_radius = 2.5e-3;     // m, final, around a wound
  double blood_time = 8;            // s, time constant with which the stain grows
};

/// A point where a cut of the soft tissue bleeds.
struct SoftWound {
  Nanos t = 0;   // time at which the bleeding began, ns
  dvec3 p_W{0};  // m, position of the wound
};
/// m, `age` s after the start.
double blood_radius(const SoftLaw& law, double age) noexcept;

/// For the renderer.
struct SoftMove {
  std::uint32_t point = 0;  // index in SoftSurface::points()
  // m below rest, elastic plus cut
  float inward = 0;
};

}  // namespace typodont::haptics
