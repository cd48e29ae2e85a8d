// Finds and removes shading: a smooth change of the grey values across a scan that is an error of the scanner
// (cupping).
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

/// The error of the grey values of a scan as a polynomial in the position.
struct Shading {
  static constexpr int kDegree = 4;
  static constexpr std::size_t kTerms = 35;  // number of monomials up to the degree kDegree, with the constant

  glm::dvec3 centre{0},
      half{1};  // m, centre of the scan and half of its extent; the variable of the polynomial is (p - centre) / half
  std::array<double, kTerms> coefficient{};  // coefficients of the polynomial, in the order of powers()
  double range = 0;                          // grey values, difference between the largest and the smallest error

  /// Returns the exponents of the three coordinates in each term. The first term is the constant.
  static const std::array<glm::ivec3, kTerms>& powers();
  /// Subtracts the error from the grey values of the scan, or of a region of it.
  void remove_from(Scan& scan) const;
};

/// Finds the shading of a scan: an error of its grey values that changes slowly across the scan, as a polynomial. In
/// uniform tissue and in air, the true grey value is constant, so the gradient of the grey value is the gradient of the
/// error. The polynomial is fitted to these gradients. Regions that contradict the others (bone whose density changes)
/// have little weight. The constant term is chosen so that the median of the error in the outer part of the scan is 0.
/// `smooth` contains the scan's grey values after slight smoothing, and `noise` is the standard deviation of the scan's
/// noise. Returns no value if the error varies by less than 100 grey values (Hounsfield units) or if the scan has too
/// few uniform regions.
std::optional<Shading> find_shading(const Scan& scan, const Grid<float>& smooth, double noise);

}  // namespace typodont::haptics::importing
