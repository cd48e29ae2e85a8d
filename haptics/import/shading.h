// Removes a smooth error of the grey values of a scan (shading, cupping).
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

/// Shading of a scan: a polynomial in the position.
struct Shading {
  static constexpr int kDegree = 4;
  static constexpr std::size_t kTerms = 35;  // number of terms of a polynomial in x, y, z of degree kDegree

  glm::dvec3 centre{0}, half{1};             // m; the variable of the polynomial is (p - centre) / half
  std::array<double, kTerms> coefficient{};  // coefficients of the polynomial, in the order of powers()
  double range = 0;                          // grey values, difference between the largest and the smallest error

  /// Exponents of x, y, z of each term; the constant is the first.
  static const std::array<glm::ivec3, kTerms>& powers();
  /// Subtracts the shading from a scan, or from a region of it.
  void remove_from(Scan& scan) const;
};

/// Fits the error. In uniform tissue and air, it has the gradient of the grey value; regions that contradict the fit
/// get little weight. Near the scan's faces, the median error is 0. `smooth`: slightly smoothed scan; `noise`: standard
/// deviation of noise. Returns nullopt if the error's range is below 100 grey values, or for few uniform regions.
std::optional<Shading> find_shading(const Scan& scan, const Grid<float>& smooth, double noise);

}  // namespace typodont::haptics::importing
