// A tooth from a few numbers (assets/teeth/forms/): drawn and monitored, not cut.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont {

/// Hill of the chewing surface (cusp, ridge, edge): a cone with a rounded tip.
struct ToothHill {
  glm::dvec2 at{0, 0};       // m, x and y
  double height = 0;         // m, height of the tip above the neck
  double slope = 0.5;        // m per m, slope of the cone
  glm::dvec2 long_by{1, 1};  // stretch along x and y
};

/// x to the midline, y to the cheek, z out of the crown, origin in the neck. m.
struct ToothForm {
  /// m, full widths, x and y
  glm::dvec2 widest{0, 0};
  glm::dvec2 neck{0, 0};  // m, full widths, x and y
  /// m, at the chewing surface
  glm::dvec2 table{0, 0};
  double height = 0;  // m, height of the crown up to its highest cusp
  // m, widest point towards neighbours, cheek, tongue
  double proximal = 0, buccal = 0, lingual = 0;
  // of the superellipse; 2: ellipse
  double square = 2.5;
  double rounding = 0;  // m, side to chewing surface
  double lean = 0;      // m per m, inclination of the crown towards the tongue
  double root = 0;      // m, length of the tooth's root
  double groove_depth = 0, groove_width = 0;
  std::vector<ToothHill> hills;

  /// m, approximate, negative inside; gradient at most about 1.3.
  double distance(const dvec3& p) const;
  /// Returns the tissue at a point inside or at the surface.
  Tissue tissue(const dvec3& p) const;
  /// m, corners of its box.
  dvec3 low() const;
  dvec3 high() const;
};

/// Reads the shape of a tooth from JSON. Throws Error.
ToothForm read_tooth_form(const Json& json);

}  // namespace typodont
