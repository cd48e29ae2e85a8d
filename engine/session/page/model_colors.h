// Colours for pictures and the rotatable view; sRGB, 0–255.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"

namespace typodont::session {

/// Colour of each Tissue. Colour-blind readers can distinguish them (tests/unit/color_vision_test.cpp).
inline constexpr std::array<std::array<int, 3>, kTissueCount> kTissueColors = {{{200, 200, 200},
                                                                                {236, 230, 216},
                                                                                {221, 197, 150},
                                                                                {110, 62, 28},
                                                                                {196, 62, 74},
                                                                                {210, 214, 112},
                                                                                {170, 152, 96},
                                                                                {222, 112, 142},
                                                                                {98, 92, 110},
                                                                                {156, 200, 206}}};

/// Colours for deviations from the target shape. Blue: too much tissue left; grey: no deviation; red: too deep.
/// Colour-blind readers can distinguish them.
inline constexpr std::array<std::array<int, 3>, 3> kDifferenceColors = {
    {{33, 102, 172}, {226, 226, 222}, {190, 40, 30}}};

/// Colour of a deviation. `fraction`: -1 too deep, 0 none, 1 too much left.
inline glm::vec3 difference_color(float fraction) {
  const float s = std::clamp(fraction, -1.0f, 1.0f);
  const auto& end = kDifferenceColors[s > 0 ? 0 : 2];
  const auto& middle = kDifferenceColors[1];
  glm::vec3 c;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    c[k] = static_cast<float>(middle[i]) + std::abs(s) * static_cast<float>(end[i] - middle[i]);
  }
  return c;
}

}  // namespace typodont::session
