// Materials of bodies that are only drawn. Their numbers continue the numbers of contract/tissue.h, but they are not
// tissues: they occur only in render::Vertex, never in a field, a file or a force.
#pragma once

#include <array>
#include <string_view>

#include "engine/contract/tissue.h"

namespace typodont::render {

inline constexpr Tissue kMucosa{kTissueCount}, kTongue{kTissueCount + 1}, kSkin{kTissueCount + 2},
    kRubber{kTissueCount + 3}, kAcrylic{kTissueCount + 4}, kPlastic{kTissueCount + 5};
// number of tissues and materials; also the length of the arrays in shared.h
inline constexpr int kMatterCount = kTissueCount + 6;

/// Returns the name of a tissue or material in files, for example "enamel" or "rubber". `index`: 0 to kMatterCount - 1.
inline std::string_view matter_name(int index) noexcept {
  constexpr std::array<std::string_view, kMatterCount - kTissueCount> kNames = {"mucosa", "tongue",  "skin",
                                                                                "rubber", "acrylic", "plastic"};
  return index < kTissueCount ? name_of(static_cast<Tissue>(index))
                              : kNames[static_cast<std::size_t>(index - kTissueCount)];
}

}  // namespace typodont::render
