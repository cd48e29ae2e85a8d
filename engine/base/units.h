// Unit literals, and factors for inputs and outputs. Inside the program, all values are in SI units: m, N, s, rad, kg,
// J.
#pragma once

#include <numbers>

namespace typodont {

inline constexpr double kPi = std::numbers::pi;

// Example: length_m = length_mm * kMillimetre.
inline constexpr double kMillimetre = 1e-3;                // m, one millimetre
inline constexpr double kMicrometre = 1e-6;                // m, one micrometre
inline constexpr double kCubicMillimetre = 1e-9;           // m³, one cubic millimetre
inline constexpr double kSquareMillimetre = 1e-6;          // m², one square millimetre
inline constexpr double kNewtonPerMillimetre = 1e3;        // N/m, one newton per millimetre
inline constexpr double kJoulePerCubicMillimetre = 1e9;    // J/m³, one joule per cubic millimetre
inline constexpr double kKrpm = 2 * kPi * 1000.0 / 60.0;   // rad/s, one thousand revolutions per minute
inline constexpr double kDegree = kPi / 180.0;             // rad, one degree
inline constexpr double kMillilitrePerMinute = 1e-6 / 60;  // m³/s, one millilitre per minute
inline constexpr double kGramPerCubicCentimetre = 1e3;     // kg/m³, one gram per cubic centimetre

namespace literals {
constexpr double operator""_mm(long double v) {
  return static_cast<double>(v) * kMillimetre;
}
constexpr double operator""_um(long double v) {
  return static_cast<double>(v) * kMicrometre;
}
constexpr double operator""_mm3(long double v) {
  return static_cast<double>(v) * kCubicMillimetre;
}
constexpr double operator""_krpm(long double v) {
  return static_cast<double>(v) * kKrpm;
}
constexpr double operator""_deg(long double v) {
  return static_cast<double>(v) * kDegree;
}
}  // namespace literals

}  // namespace typodont
