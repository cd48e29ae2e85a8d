// Estimates the speed of the rotor from spectral lines of a recording.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

inline constexpr double kLineWindow = 4096.0 / 48000;  // s, length of the analysis window

struct SpectralLine {
  double frequency = 0;   // Hz, frequency of this spectral line
  double prominence = 0;  // dB, peak's height above the median of the neighbouring frequencies
  double level_dB = 0;    // dB re 1/Hz at the peak
};
/// Peaks of the smoothed spectrum, the strongest first. `window` (s): a longer window finds weak lines of constant
/// frequency.
std::vector<SpectralLine> spectral_lines(std::span<const double> x, double rate, double at_least_dB = 8,
                                         double window = kLineWindow);

/// Distance (Hz) between the lines of the best harmonic series; 0: none. Twice the true value if odd harmonics are
/// weak.
double estimated_rotor_frequency(std::span<const double> x, double rate);

}  // namespace typodont::audio
