// Helpers for chips and droplets: the distance field near a point, the air of the suction, and the test whether a path
// crosses the nozzle.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/glm.hpp>

#include "engine/base/nearest.h"
#include "engine/base/units.h"
#include "engine/debris/debris.h"
#include "engine/debris/motion/motion.h"

namespace typodont::debris {

/// Distance field near a point, interpolated linearly in one cell.
class Contact {
 public:
  Contact(const CoarseField& field, const glm::dvec3& p_W) {
    if (!field.distance) return;
    const glm::dvec3 q = (p_W - field.origin) * (1 / field.spacing);
    const glm::dvec3 low = glm::floor(q);
    const glm::ivec3 i(low);
    if (!glm::all(glm::greaterThanEqual(low, glm::dvec3(0))) ||
        !glm::all(glm::lessThan(low, glm::dvec3(field.size - 1)))) {
      return;
    }
    f_ = q - low;
    const std::size_t sy = static_cast<std::size_t>(field.size.z), sx = sy * static_cast<std::size_t>(field.size.y);
    const float* d = field.distance + static_cast<std::size_t>(i.x) * sx + static_cast<std::size_t>(i.y) * sy +
                     static_cast<std::size_t>(i.z);
    d_ = {d[0], d[1], d[sy], d[sy + 1], d[sx], d[sx + 1], d[sx + sy], d[sx + sy + 1]};
    for (std::size_t k = 0; k < 4; ++k) x_[k] = glm::mix(d_[k], d_[k + 4], f_.x);
    inside = true;
    distance = glm::mix(glm::mix(x_[0], x_[2], f_.y), glm::mix(x_[1], x_[3], f_.y), f_.z);
  }
  /// Returns the gradient of the distance, not normalised. Valid only if `inside`.
  glm::dvec3 gradient() const {
    return {glm::mix(glm::mix(d_[4] - d_[0], d_[6] - d_[2], f_.y), glm::mix(d_[5] - d_[1], d_[7] - d_[3], f_.y), f_.z),
            glm::mix(x_[2] - x_[0], x_[3] - x_[1], f_.z), glm::mix(x_[1], x_[3], f_.y) - glm::mix(x_[0], x_[2], f_.y)};
  }
  bool inside = false;  // true if the point lies in the field's box
  double distance = 0;  // m, signed distance of the point to the tissue's surface

 private:
  glm::dvec3 f_{0};            // position in the grid cell, 0..1 along each axis
  std::array<double, 8> d_{};  // m, distances at the corners of the grid cell
  std::array<double, 4> x_{};  // the distances `d_` after interpolation along x
};

/// Returns the mean velocity (m/s) of the air at a point during a step.
inline glm::dvec3 suction_velocity(const Suction& suction, const glm::dvec3& p_W, double dt) {
  const glm::dvec3 offset = suction.p_W - p_W;
  const double r = std::max(glm::length(offset), 1e-6);
  return mean_air_speed(suction.flow / (4 * kPi), r, dt) / r * offset;
}

/// Returns true if the line from a to b passes c at a distance below `radius`.
inline bool passed_within(double radius, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  return distance_to_segment(a, b, c) < radius;
}

}  // namespace typodont::debris
