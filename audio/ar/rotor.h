// Estimates the rotor's speed from the spectral lines of a recording.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

inline constexpr double kLineWindow = 4096.0 / 48000;  // s, length of the analysis window

struct SpectralLine {
  double frequency = 0;   // Hz, frequency of this spectral line
  double prominence = 0;  // dB, height of the line's peak above the median of the neighbouring spectrum
  double level_dB = 0;    // dB re 1/Hz, power density of the sound at the peak of this spectral line
};
/// Returns the peaks of the smoothed spectrum, strongest first. `window`: s, length of the analysis windows; a longer
/// window resolves weaker lines if their frequency is constant.
std::vector<SpectralLine> spectral_lines(std::span<const double> x, double rate, double at_least_dB = 8,
                                         double window = kLineWindow);

/// Returns the spacing (Hz) of the harmonic series that explains the spectral lines of the recording `x` best; 0 if
/// there is none. This is an estimate: if the odd harmonics are weak, it is twice the true spacing. `rate`: Hz, sample
/// rate.
double estimated_rotor_frequency(std::span<const double> x, double rate);

}  // namespace typodont::audio
