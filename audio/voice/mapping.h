// Relates hand work to the sound. Sources: audio/README.md.
#pragma once

#include <algorithm>
#include <cmath>

namespace typodont::audio {

// Values at which 63 % of the idle sound is replaced by the sound of cutting.
inline constexpr double kTypicalArea = 1e-6;     // m², contact area of a typical contact
inline constexpr double kTypicalForce = 1;       // N, force of a typical contact
inline constexpr double kTypicalRemoval = 1e-9;  // m³/s, removal rate of a typical cut
inline constexpr double kEdgeArea = 2e-6;        // m², contact that doubles the power of the working sound
inline constexpr double kMaxArea = 20e-6;        // m², larger contacts sound alike
inline constexpr double kBrightForce = 1.5;      // N, force that gives 63 % of the largest brightness
// Removal rate for 63 % of the largest brightness, m³/s.
inline constexpr double kBrightRemoval = 0.5e-9;
inline constexpr double kBrightFrom = 4000;  // Hz; above it, force and removal make the sound louder

// Exponent of the idle amplitude as a function of the speed, measured on a run-down.
inline constexpr double kIdleExponent = 3.75;

/// Fraction of the sound of cutting, 0..1.
inline double load_of(double area, double force, double removal) noexcept {
  return 1 - std::exp(-(area / kTypicalArea + force / kTypicalForce + removal / kTypicalRemoval));
}
/// Amplitude of the working sound, 1 for a typical contact. The powers of edges that cut independently add up.
inline double loudness_of(double area) noexcept {
  const auto power = [](double a) { return 1 + std::min(a, kMaxArea) / kEdgeArea; };
  return std::sqrt(power(area) / power(kTypicalArea));
}
/// Brightness as a fraction of its largest value, 0..1.
inline double brightness_of(double force, double removal) noexcept {
  return 1 - std::exp(-(force / kBrightForce + removal / kBrightRemoval));
}

}  // namespace typodont::audio
