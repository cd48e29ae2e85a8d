// Old surface, ideal and result in a section, as SVG.
#pragma once

#include <string>

#include "engine/session/cavity.h"

namespace typodont::session {

/// For example "distal" and "mesial"; may be empty.
struct SectionSides {
  std::string left, right;
};

/// Through `through_W`, with the axis upwards and `along_W`, perpendicular to it, to the right.
std::string section_svg(const Preparation& preparation, const dvec3& through_W, const dvec3& along_W,
                        const std::string& label, const SectionSides& sides);

}  // namespace typodont::session
