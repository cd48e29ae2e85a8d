// A section through the preparation with the old surface, the ideal and the result, as inline SVG.
#pragma once

#include <string>

#include "engine/session/cavity.h"

namespace typodont::session {

/// Labels at the left and the right of a section, e.g. "distal" and "mesial"; may be empty.
struct SectionSides {
  std::string left, right;
};

/// The section plane passes through `through_W`; it contains the preparation's axis (upright) and `along_W` (to the
/// right, perpendicular to the axis).
std::string section_svg(const Preparation& preparation, const dvec3& through_W, const dvec3& along_W,
                        const std::string& label, const SectionSides& sides);

}  // namespace typodont::session
