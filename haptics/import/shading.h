// Smooth error of grey values (cupping).
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

/// Polynomial in the position.
struct Shading {
  static constexpr int kDegree = 4;
  static constexpr std::size_t kTerms = 35;  // up to kDegree, with the constant

  glm::dvec3 centre{0}, half{1};             // m; variable (p - centre) / half
  std::array<double, kTerms> coefficient{};  // coefficients of the polynomial, in the order of powers()
  double range = 0;                          // grey values, difference between the largest and the smallest error

  /// Constant first.
  static const std::array<glm::ivec3, kTerms>& powers();
  /// From a scan or region.
  void remove_from(Scan& scan) const;
};

/// In uniform tissue and air, the gradient is the error's; contradicting regions weigh little. Median 0 in the outer
/// part. `smooth`: slightly, `noise`: σ. Empty below a range of 100, or with too few uniform regions.
std::optional<Shading> find_shading(const Scan& scan, const Grid<float>& smooth, double noise);

}  // namespace typodont::haptics::importing
