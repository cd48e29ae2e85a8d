// Draws a section through the preparation with the old surface, the target shape and the result, as SVG in the page.
#pragma once

#include <string>

#include "engine/session/cavity.h"

namespace typodont::session {

/// Labels for the left and the right side of a section, for example "distal" and "mesial". They may be empty.
struct SectionSides {
  std::string left, right;
};

/// Draws the section. Its plane passes through `through_W` and contains the preparation's axis (upwards in the drawing)
/// and `along_W` (to the right, perpendicular to the axis).
std::string section_svg(const Preparation& preparation, const dvec3& through_W, const dvec3& along_W,
                        const std::string& label, const SectionSides& sides);

}  // namespace typodont::session
