// The tissue spheres of the contact model "packing", for the renderer.
#pragma once

#include <vector>

#include "haptics/carver.h"

namespace typodont::haptics {

/// A sphere of the tissue in its present state.
struct ShownSphere {
  dvec3 p_W{0};        // m, centre
  double radius = 0;   // m
  double density = 0;  // relative to dentin; decides the cutting speed
};

/// All that remain; empty with another method. Carver thread.
std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings);

}  // namespace typodont::haptics
