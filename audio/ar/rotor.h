// Estimates the rotor's speed from the spectral lines of a recording.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

struct SpectralLine {
  double frequency = 0;   // Hz
  double prominence = 0;  // dB above the median of the neighbouring spectrum
  double level_dB = 0;    // power density, dB re 1/Hz
};
/// Peaks of the smoothed spectrum, strongest first.
std::vector<SpectralLine> spectral_lines(std::span<const double> x, double rate, double at_least_dB = 8);

/// Hz, the spacing of the harmonic series that explains the lines best; 0 if there is none. This is an estimate: if the
/// odd harmonics are weak, it returns twice the true spacing.
double estimated_rotor_frequency(std::span<const double> x, double rate);

}  // namespace typodont::audio
