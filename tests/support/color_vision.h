// What a colour-blind person sees, and how different two colours look.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "engine/base/units.h"

namespace typodont::test {

enum class Vision { kNormal, kProtan, kDeutan, kTritan };
inline constexpr std::array kVisions = {Vision::kNormal, Vision::kProtan, Vision::kDeutan, Vision::kTritan};

/// Linear RGB as a person of this vision sees an sRGB colour (0..255): matrices of Machado, Oliveira & Fernandes, IEEE
/// Trans. Vis. Comput. Graph. 15 (2009), severity 1.
inline glm::dvec3 seen_by(Vision vision, const glm::dvec3& srgb) {
  glm::dvec3 linear;
  for (int i = 0; i < 3; ++i) {
    const double c = srgb[i] / 255;
    linear[i] = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  }
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

/// Relative luminance of linear RGB.
inline double luminance(const glm::dvec3& linear) {
  return glm::dot(linear, glm::dvec3(0.2126729, 0.7151522, 0.0721750));
}

/// CIE L*a*b* of linear RGB, white point D65.
inline glm::dvec3 lab_of(const glm::dvec3& linear) {
  const double xyz[3] = {glm::dot(linear, glm::dvec3(0.4124564, 0.3575761, 0.1804375)) / 0.95047, luminance(linear),
                         glm::dot(linear, glm::dvec3(0.0193339, 0.1191920, 0.9503041)) / 1.08883};
  double f[3];
  for (int i = 0; i < 3; ++i) f[i] = xyz[i] > 216.0 / 24389 ? std::cbrt(xyz[i]) : (24389.0 / 27 * xyz[i] + 16) / 116;
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

/// CIEDE2000 of two L*a*b* colours (Sharma, Wu & Dalal, Color Res. Appl. 30 (2005)).
inline double ciede2000(const glm::dvec3& one, const glm::dvec3& two) {
  constexpr double kDegree = kPi / 180;
  const auto seventh = [](double c) { return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7))); };
  const double mean = 0.5 * (std::hypot(one.y, one.z) + std::hypot(two.y, two.z));
  const double stretch = 1 + 0.5 * (1 - seventh(mean));
  const double a1 = stretch * one.y, a2 = stretch * two.y;
  const double c1 = std::hypot(a1, one.z), c2 = std::hypot(a2, two.z);
  const auto hue = [&](double b, double a) {
    const double h = a == 0 && b == 0 ? 0.0 : std::atan2(b, a) / kDegree;
    return h < 0 ? h + 360 : h;
  };
  const double h1 = hue(one.z, a1), h2 = hue(two.z, a2);
  double dh = h2 - h1, hm = h1 + h2;
  if (c1 * c2 == 0) {
    dh = 0;
  } else {
    if (std::abs(dh) > 180) {
      dh += dh > 0 ? -360 : 360;
      hm += hm < 360 ? 360 : -360;
    }
    hm /= 2;
  }
  const double dl = two.x - one.x, dc = c2 - c1, dH = 2 * std::sqrt(c1 * c2) * std::sin(0.5 * dh * kDegree);
  const double lm = 0.5 * (one.x + two.x), cm = 0.5 * (c1 + c2);
  const double t = 1 - 0.17 * std::cos((hm - 30) * kDegree) + 0.24 * std::cos(2 * hm * kDegree) +
                   0.32 * std::cos((3 * hm + 6) * kDegree) - 0.20 * std::cos((4 * hm - 63) * kDegree);
  const double sl = 1 + 0.015 * (lm - 50) * (lm - 50) / std::sqrt(20 + (lm - 50) * (lm - 50));
  const double sc = 1 + 0.045 * cm, sh = 1 + 0.015 * cm * t;
  const double turn = 30 * std::exp(-std::pow((hm - 275) / 25, 2));
  const double rt = -std::sin(2 * turn * kDegree) * 2 * seventh(cm);
  const double l = dl / sl, c = dc / sc, h = dH / sh;
  return std::sqrt(l * l + c * c + h * h + rt * c * h);
}

/// CIEDE2000 of two sRGB colours (0..255) as a person of this vision sees them.
inline double difference(Vision vision, const glm::dvec3& one, const glm::dvec3& two) {
  return ciede2000(lab_of(seen_by(vision, one)), lab_of(seen_by(vision, two)));
}

}  // namespace typodont::test
