// Unit literals that only tests use, besides those of engine/base/units.h.
#pragma once

#include "engine/base/units.h"

namespace typodont::literals {
constexpr double operator""_um(long double v) {
  return static_cast<double>(v) * kMicrometre;
}
constexpr double operator""_mm3(long double v) {
  return static_cast<double>(v) * kCubicMillimetre;
}
constexpr double operator""_N_per_mm(long double v) {
  return static_cast<double>(v) * kNewtonPerMillimetre;
}
constexpr double operator""_krpm(long double v) {
  return static_cast<double>(v) * kKrpm;
}
constexpr double operator""_deg(long double v) {
  return static_cast<double>(v) * kDegree;
}
}  // namespace typodont::literals
