// The shape of a tooth, described by a few numbers (assets/teeth/forms/): neck, widest part, cusps and grooves. It is
// used for teeth that are only drawn and monitored, not cut.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont {

/// A part of the chewing surface, called a hill: a cusp, a ridge, or the cutting edge of a front tooth. Its shape is a
/// cone with a rounded tip.
struct ToothHill {
  glm::dvec2 at{0, 0};       // m, position of the tip along x and y of the tooth's frame
  double height = 0;         // m, height of the tip above the neck
  double slope = 0.5;        // m per m, slope of the cone
  glm::dvec2 long_by{1, 1};  // factors that stretch the hill's (cusp's) cone along x and y of the tooth's frame
};

/// The shape of a tooth. In its frame, x points along the row to the jaw's midline, y to the cheek and z out of the
/// crown; the origin is the middle of the neck. Lengths in m.
struct ToothForm {
  /// m, full widths at the widest part, along x and y of the tooth's frame
  glm::dvec2 widest{0, 0};
  glm::dvec2 neck{0, 0};  // m, full widths at the neck, along x and y of the tooth's frame
  /// m, full widths at the chewing surface, along x and y of the tooth's frame
  glm::dvec2 table{0, 0};
  double height = 0;  // m, height of the crown up to its highest cusp
  // m, heights of the widest point on the sides towards neighbours, cheek and tongue
  double proximal = 0, buccal = 0, lingual = 0;
  // exponent of the superellipse that the tooth's outline has, seen from above; 2 gives an ellipse
  double square = 2.5;
  double rounding = 0;  // m, radius of the edge between the side and the chewing surface
  double lean = 0;      // m per m, inclination of the crown towards the tongue
  double root = 0;      // m, length of the tooth's root
  double groove_depth = 0, groove_width = 0;
  std::vector<ToothHill> hills;

  /// Returns the approximate distance (m) to the tooth's surface, negative inside. The gradient of this distance is at
  /// most about 1.3 (1 for an exact distance).
  double distance(const dvec3& p) const;
  /// Returns the tissue at a point inside or at the surface.
  Tissue tissue(const dvec3& p) const;
  /// low() and high() return two opposite corners (m) of a box that contains the tooth.
  dvec3 low() const;
  dvec3 high() const;
};

/// Reads the shape of a tooth from JSON. Throws Error.
ToothForm read_tooth_form(const Json& json);

}  // namespace typodont
