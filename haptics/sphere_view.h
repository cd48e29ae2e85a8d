// The spheres of a tissue of the model "packing", for pictures.
#pragma once

#include <vector>

#include "haptics/carver.h"

namespace typodont::haptics {

/// A sphere as cuts left it.
struct ShownSphere {
  dvec3 p_W{0};        // m
  double radius = 0;   // m
  double density = 0;  // over dentin's: what decides how fast it is cut
};

/// All that are left. Carver thread. Empty where the carver's method is another.
std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings);

}  // namespace typodont::haptics
