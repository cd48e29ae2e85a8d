// The laws by which the hand's work changes the drill's sound. audio/README.md gives their sources.
#pragma once

#include <cmath>

namespace typodont::audio {

// Scales of contact: at each of them, 63 % of the idle sound is replaced by the working sound.
inline constexpr double kTypicalArea = 1e-6;      // m², contact area
inline constexpr double kTypicalForce = 1;        // N, force
inline constexpr double kTypicalRemoval = 1e-9;   // m³/s, removal rate
inline constexpr double kBrightForce = 1.5;       // N: at this force, high frequencies have 63 % of their gain
inline constexpr double kBrightRemoval = 0.5e-9;  // m³/s: at this removal rate, high frequencies have 63 %
inline constexpr double kBrightFrom = 4000;       // Hz, lower edge of the high frequencies

inline constexpr double kIdleExponent = 3.75;  // amplitude of idling ~ speed^3.75, measured on a run-down

/// 0..1, fraction of the way from the idle to the working sound.
inline double load_of(double area, double force, double removal) noexcept {
  return 1 - std::exp(-(area / kTypicalArea + force / kTypicalForce + removal / kTypicalRemoval));
}
/// 0..1, fraction of the gain of high frequencies.
inline double brightness_of(double force, double removal) noexcept {
  return 1 - std::exp(-(force / kBrightForce + removal / kBrightRemoval));
}

}  // namespace typodont::audio
