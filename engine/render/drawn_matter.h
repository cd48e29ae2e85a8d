// Materials of bodies that are only drawn. They continue the numbers of contract/tissue.h, but they are no tissue: they
// occur in render::Vertex only, never in a field, a file or a force.
#pragma once

#include "engine/contract/tissue.h"

namespace typodont::render {

inline constexpr Tissue kMucosa{kTissueCount}, kTongue{kTissueCount + 1}, kSkin{kTissueCount + 2},
    kRubber{kTissueCount + 3}, kAcrylic{kTissueCount + 4}, kPlastic{kTissueCount + 5};
inline constexpr int kMatterCount = kTissueCount + 6;  // also the length of the arrays in shared.h

}  // namespace typodont::render
