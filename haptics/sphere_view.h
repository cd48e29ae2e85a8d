// The tissue spheres of the contact model "packing", for the renderer.
#pragma once

#include <vector>

#include "haptics/carver.h"

namespace typodont::haptics {

/// A sphere of the tissue in its present state.
struct ShownSphere {
  dvec3 p_W{0};        // m, centre
  double radius = 0;   // m
  double density = 0;  // density relative to dentin; it determines the cutting speed
};

/// Returns all remaining spheres; empty if the carver uses another method. Carver thread only.
std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings);

}  // namespace typodont::haptics
