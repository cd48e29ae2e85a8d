// Draws a section (SVG): the surface before the work, the ideal shape, and the result.
#pragma once

#include <string>

#include "engine/session/cavity.h"

namespace typodont::session {

/// Labels at the section's left and right edge, for example "distal" and "mesial". May be empty.
struct SectionSides {
  std::string left, right;
};

/// Draws the section through `through_W`. The task's axis points upwards, and `along_W`, perpendicular to it, to the
/// right.
std::string section_svg(const Preparation& preparation, const dvec3& through_W, const dvec3& along_W,
                        const std::string& label, const SectionSides& sides);

}  // namespace typodont::session
