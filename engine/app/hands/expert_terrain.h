// Heights of the obstacles over which a tool is moved.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "engine/app/surroundings/surroundings.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Height map of tissue, neighbouring teeth and gum, on a grid perpendicular to the preparation's axis.
class Terrain {
 public:
  /// `axis`: unit vector. `around`: shape of the surroundings, or null.
  Terrain(const haptics::TissueVolume& tissue, const SurroundingsShape* around, const dvec3& axis);
  /// Height of the highest point that is nearer than `beside` (m) to the line from a to b; m along the axis.
  double highest(const dvec3& a, const dvec3& b, double beside) const;

 private:
  // Size of a cell, and margin around the tissue, m.
  static constexpr double kCell = 0.2e-3, kRim = 2e-3;
  std::size_t cell(const glm::ivec2& at) const {
    return static_cast<std::size_t>(at.x) * static_cast<std::size_t>(size_.y) + static_cast<std::size_t>(at.y);
  }
  glm::ivec2 cell_of(const dvec3& p) const {
    const glm::dvec2 q(glm::dot(p, u_), glm::dot(p, v_));
    return glm::clamp(glm::ivec2(glm::floor((q - lo_) / kCell)), glm::ivec2(0), size_ - 1);
  }

  dvec3 u_, v_, w_;
  glm::dvec2 lo_{0};  // m along u and v, origin of the grid
  glm::ivec2 size_{0};
  std::vector<double> height_;  // m along w, height of each cell
};

}  // namespace typodont
