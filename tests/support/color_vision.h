// Computes what a colour-blind person sees, and how different two colours look to this person.
#pragma once

#include <algorithm>
#include <array>
#include <glm/glm.hpp>

#include "engine/render/srgb.h"
#include "tests/support/picture_difference.h"

namespace typodont::test {

enum class Vision { kNormal, kProtan, kDeutan, kTritan };
inline constexpr std::array kVisions = {Vision::kNormal, Vision::kProtan, Vision::kDeutan, Vision::kTritan};

/// Returns the linear RGB colour that a person with this vision sees for an sRGB colour (0..255). The matrices are
/// those of Machado, Oliveira & Fernandes, IEEE Trans. Vis. Comput. Graph. 15 (2009), severity 1.
inline glm::dvec3 seen_by(Vision vision, const glm::dvec3& srgb) {
  const glm::dvec3 linear = render::linear_light(srgb / 255.0);
  constexpr double kMatrices[4][3][3] = {
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
      {{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}},
      {{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}},
      {{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}};
  const auto& m = kMatrices[static_cast<std::size_t>(vision)];
  glm::dvec3 result;
  for (int i = 0; i < 3; ++i)
    result[i] = std::clamp(m[i][0] * linear[0] + m[i][1] * linear[1] + m[i][2] * linear[2], 0.0, 1.0);
  return result;
}

/// Returns the relative luminance of a linear RGB colour.
inline double luminance(const glm::dvec3& linear) {
  return glm::dot(linear, glm::dvec3(0.2126729, 0.7151522, 0.0721750));
}

/// Returns the colour difference (CIEDE2000) of two sRGB colours (0..255) for a person with this vision.
inline double difference(Vision vision, const glm::dvec3& one, const glm::dvec3& two) {
  const auto lab = [&](const glm::dvec3& srgb) { return render::lab_of_linear(seen_by(vision, srgb)); };
  return render::ciede2000(lab(one), lab(two));
}

}  // namespace typodont::test
