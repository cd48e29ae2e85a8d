// Materials that are only drawn, not simulated. Their numbers begin after the last tissue of contract/tissue.h, and
// occur only in render::Vertex.
#pragma once

#include <array>
#include <string_view>

#include "engine/contract/tissue.h"

namespace typodont::render {

inline constexpr Tissue kMucosa{kTissueCount}, kTongue{kTissueCount + 1}, kSkin{kTissueCount + 2},
    kRubber{kTissueCount + 3}, kAcrylic{kTissueCount + 4}, kPlastic{kTissueCount + 5};
// Number of tissues and drawn materials; length of the arrays of tissues in shared.h.
inline constexpr int kMatterCount = kTissueCount + 6;

/// Name of a tissue or material in files, for example "enamel", "rubber". `index`: 0 to kMatterCount - 1.
inline std::string_view matter_name(int index) noexcept {
  constexpr std::array<std::string_view, kMatterCount - kTissueCount> kNames = {"mucosa", "tongue",  "skin",
                                                                                "rubber", "acrylic", "plastic"};
  return index < kTissueCount ? name_of(static_cast<Tissue>(index))
                              : kNames[static_cast<std::size_t>(index - kTissueCount)];
}

}  // namespace typodont::render
