// The height of everything that a tool must pass over when the expert moves it.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "engine/app/surroundings/surroundings.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Height map of tissue, neighbouring teeth and gum, on a grid perpendicular to the preparation's axis. Tools are
/// lifted above this height.
class Terrain {
 public:
  /// `axis`: unit vector of the preparation's axis. `around`: neighbouring teeth and gum, or null.
  Terrain(const haptics::TissueVolume& tissue, const SurroundingsShape* around, const dvec3& axis);
  /// Returns the height (m, along the preparation's axis) of the highest tissue near the straight path from a to b.
  /// Tissue is near if its distance from this path, measured perpendicular to the axis, is at most `beside` (m).
  double highest(const dvec3& a, const dvec3& b, double beside) const;

 private:
  // kCell: m, cell size of the height map's grid; kRim: m, margin of this grid around the tissue
  static constexpr double kCell = 0.2e-3, kRim = 2e-3;
  std::size_t cell(const glm::ivec2& at) const {
    return static_cast<std::size_t>(at.x) * static_cast<std::size_t>(size_.y) + static_cast<std::size_t>(at.y);
  }
  glm::ivec2 cell_of(const dvec3& p) const {
    const glm::dvec2 q(glm::dot(p, u_), glm::dot(p, v_));
    return glm::clamp(glm::ivec2(glm::floor((q - lo_) / kCell)), glm::ivec2(0), size_ - 1);
  }

  dvec3 u_, v_, w_;
  glm::dvec2 lo_{0};  // m along the axes u and v, origin of the height map's grid
  glm::ivec2 size_{0};
  std::vector<double> height_;  // m along the axis w, height of the tissue in each grid cell
};

}  // namespace typodont
