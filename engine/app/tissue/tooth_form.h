// The form of a tooth, defined by a few numbers (assets/teeth/forms/).
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont {

/// A hill of the chewing surface (cusp, ridge or edge): a cone with a rounded tip.
struct ToothHill {
  glm::dvec2 at{0, 0};       // m, x and y
  double height = 0;         // m, height of the tip above the neck
  double slope = 0.5;        // m per m, slope of the cone
  glm::dvec2 long_by{1, 1};  // stretch along x and y
  // m, height difference below which a ridge passes smoothly into other hills; 0: a cusp, with grooves around it
  double join = 0;

  bool is_cusp() const { return join == 0; }
};

/// What distinguishes the sides of a crown. All 0: the outline is symmetric.
struct CrownSides {
  double skew = 0;            // shift of the outline along x per y (rhomboid upper molars)
  double distal_narrow = 0;   // change of the width along y from the middle to the mesial (+) and distal (−) end
  double lingual_narrow = 0;  // change of the width along x from the middle to the buccal (+) and lingual (−) side
  double distal_lower = 0;    // m, by which the widest point of the distal side is lower than the mesial one
  // m, added to the radius of the edge at the mesial and the distal corner of the chewing surface
  glm::dvec2 corners{0, 0};
};

/// Frame: origin in the neck, x to the midline, y to the cheek, z out of the crown. Lengths in m.
struct ToothForm {
  /// Largest width of the crown along x and y, m.
  glm::dvec2 widest{0, 0};
  glm::dvec2 neck{0, 0};  // m, width of the neck along x and y
  /// Width at the chewing surface along x and y, m.
  glm::dvec2 table{0, 0};
  double height = 0;  // m, height of the crown up to its highest cusp
  // Height of the widest point on the sides of neighbours, cheek and tongue, m.
  double proximal = 0, buccal = 0, lingual = 0;
  // Exponent of the outline's superellipse; 2: an ellipse.
  double square = 2.5;
  double rounding = 0;  // m, edge radius between sides and chewing surface
  double lean = 0;      // m per m, inclination of the crown towards the tongue
  double root = 0;      // m, length of the tooth's root
  double groove_depth = 0, groove_width = 0;
  std::vector<ToothHill> hills;
  CrownSides sides;

  /// Approximate signed distance, m, negative inside; its gradient is at most about 1.3.
  double distance(const dvec3& p) const;
  /// The tissue at a point inside or at the surface.
  Tissue tissue(const dvec3& p) const;
  /// Lower corner of a box around the tooth, m.
  dvec3 low() const;
  dvec3 high() const;

 private:
  /// Half the widths of this box along x and y, without the inclination, m.
  glm::dvec2 half_box() const;
};

/// The folder assets/teeth/forms.
std::filesystem::path tooth_forms();
/// Declares the keys of a file with the shape of a tooth. Throws Error.
void describe_tooth_form(Keys& keys, ToothForm& form);
ToothForm read_tooth_form(const Json& json);

}  // namespace typodont
