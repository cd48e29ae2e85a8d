// The spheres of a tissue of the model "packing", for pictures.
#pragma once

#include <vector>

#include "haptics/carver.h"

namespace typodont::haptics {

/// A sphere after the cuts so far.
struct ShownSphere {
  dvec3 p_W{0};        // m
  double radius = 0;   // m
  double density = 0;  // density relative to dentin's; determines the cutting speed
};

/// All remaining spheres; empty if the carver uses another method. Carver thread.
std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings);

}  // namespace typodont::haptics
