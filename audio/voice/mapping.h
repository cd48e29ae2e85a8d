// Relates the contact of the drill to its sound. Sources: audio/README.md.
#pragma once

#include <algorithm>
#include <cmath>

namespace typodont::audio {

// Each of the next three values alone replaces 63 % of the idle sound by the sound of cutting.
inline constexpr double kTypicalArea = 1e-6;     // m², contact area of a typical contact
inline constexpr double kTypicalForce = 1;       // N, force of a typical contact
inline constexpr double kTypicalRemoval = 1e-9;  // m³/s, removal rate of a typical cut
inline constexpr double kEdgeArea = 2e-6;        // m²; doubles the power of the cutting sound, compared with area 0
inline constexpr double kMaxArea = 20e-6;        // m², above this area, contacts do not become louder
// N, force that gives 63 % of the largest brightness (amplification of high frequencies)
inline constexpr double kBrightForce = 1.5;
// Removal rate that gives 63 % of the largest brightness (amplification of high frequencies), m³/s.
inline constexpr double kBrightRemoval = 0.5e-9;
inline constexpr double kBrightFrom = 4000;  // Hz; force and removal amplify only frequencies above this

// The idle sound's amplitude is proportional to the spindle speed^kIdleExponent, measured while a drill ran down.
inline constexpr double kIdleExponent = 3.75;

/// Fraction of the sound of cutting in the mix with the idle sound, 0..1.
inline double load_of(double area, double force, double removal) noexcept {
  return 1 - std::exp(-(area / kTypicalArea + force / kTypicalForce + removal / kTypicalRemoval));
}
/// Amplitude of the cutting sound; 1 for a typical contact. Edges of the bur cut independently, so their powers add up.
inline double loudness_of(double area) noexcept {
  const auto power = [](double a) { return 1 + std::min(a, kMaxArea) / kEdgeArea; };
  return std::sqrt(power(area) / power(kTypicalArea));
}
/// Brightness (gain of high frequencies) divided by its largest value, 0..1.
inline double brightness_of(double force, double removal) noexcept {
  return 1 - std::exp(-(force / kBrightForce + removal / kBrightRemoval));
}

}  // namespace typodont::audio
