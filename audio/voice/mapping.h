// The formulas by which the hand's work changes the drill's sound. audio/README.md gives their sources.
#pragma once

#include <cmath>

namespace typodont::audio {

// Typical values of a contact: contact area (m²), force (N), and removal rate (m³/s). If one of these quantities has
// its typical value and the others are zero, 63 % of the idle sound is replaced by the working sound.
inline constexpr double kTypicalArea = 1e-6;     // m², contact area of a typical contact
inline constexpr double kTypicalForce = 1;       // N, force of a typical contact
inline constexpr double kTypicalRemoval = 1e-9;  // m³/s, removal rate of a typical cut
inline constexpr double kBrightForce = 1.5;      // N, force at which high frequencies have 63 % of their largest gain
// m³/s, removal rate at which high frequencies have 63 % of their largest gain
inline constexpr double kBrightRemoval = 0.5e-9;
inline constexpr double kBrightFrom = 4000;  // Hz; frequencies above this become louder with force and removal rate

// exponent: the amplitude of the idle sound is proportional to this power of the speed, as measured on a run-down
inline constexpr double kIdleExponent = 3.75;

/// Returns the fraction 0..1 by which the idle sound is replaced by the working sound.
inline double load_of(double area, double force, double removal) noexcept {
  return 1 - std::exp(-(area / kTypicalArea + force / kTypicalForce + removal / kTypicalRemoval));
}
/// Returns the gain of the high frequencies as a fraction 0..1 of its largest value.
inline double brightness_of(double force, double removal) noexcept {
  return 1 - std::exp(-(force / kBrightForce + removal / kBrightRemoval));
}

}  // namespace typodont::audio
