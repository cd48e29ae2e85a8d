// Directions along which the light in a mouth is followed.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>

#include "engine/base/units.h"

namespace typodont::render {

/// Unit vectors, distributed evenly over the sphere (Fibonacci's spiral).
template <std::size_t kCount>
std::array<glm::vec3, kCount> sphere_directions() {
  std::array<glm::vec3, kCount> all;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto k = static_cast<double>(i);
    const double z = 1 - (2 * k + 1) / kCount, r = std::sqrt(1 - z * z), a = kPi * (3 - std::sqrt(5.0)) * k;
    all[i] = glm::vec3(r * std::cos(a), r * std::sin(a), z);
  }
  return all;
}

}  // namespace typodont::render
