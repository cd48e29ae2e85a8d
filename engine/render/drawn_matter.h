// Materials of bodies that are only drawn. Their numbers continue the numbers of contract/tissue.h, but they are not
// tissues: they occur only in render::Vertex, never in a field, a file or a force.
#pragma once

#include "engine/contract/tissue.h"

namespace typodont::render {

inline constexpr Tissue kMucosa{kTissueCount}, kTongue{kTissueCount + 1}, kSkin{kTissueCount + 2},
    kRubber{kTissueCount + 3}, kAcrylic{kTissueCount + 4}, kPlastic{kTissueCount + 5};
// number of tissues and materials; also the length of the arrays in shared.h
inline constexpr int kMatterCount = kTissueCount + 6;

}  // namespace typodont::render
