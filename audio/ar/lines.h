// Finds, measures and removes a rotor's steady lines. Not for real time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// One entry per kLineStep samples.
struct LineTrack {
  double frequency = 0;           // Hz, mean frequency of the spectral line
  double bandwidth = 0;           // Hz, half width (−3 dB) of the band
  double floor = 0;               // one-sided power density beside the line, 1/Hz
  std::vector<double> amplitude;  // amplitude of the sinusoid; full scale is 1
  std::vector<double> deviation;  // Hz, from the mean frequency

  double mean_amplitude() const;
  /// Variances that noise alone would cause: relative to the squared mean amplitude, and Hz².
  double amplitude_variance_of_noise() const;
  double frequency_variance_of_noise() const;
  /// σ / mean of the amplitude: 0 for a sinusoid, 0.52 for narrow-band noise.
  double variation() const;
  /// variation() without the noise beside the line.
  double own_variation() const;
  /// A sinusoid, with noise weak enough to tell.
  bool steady() const {
    return !amplitude.empty() && own_variation() < kSteadyVariation && amplitude_variance_of_noise() < kWeakestLine;
  }
  // largest own_variation() of a sinusoid
  static constexpr double kSteadyVariation = 0.3;
  // amplitude variance by noise / squared mean amplitude; above it, the line is too weak
  static constexpr double kWeakestLine = 0.1;
};

/// Follows the line near `frequency` (Hz) through the middle minute. Takes the first band of 80, 40, 20 Hz half width
/// with an amplitude variance by noise below 0.02, else the steadiest. Empty below 0.2 s.
LineTrack follow_line(std::span<const double> x, double rate, double frequency);

struct TakenLine {
  ModelLine line;
  // Hz, σ of the frequency with the spindle's drift
  double spread = 0;
  // LineTrack::variation()
  double variation = 0;
};

/// Removes the steady lines, at most ten, strongest first. Changes slower than a second are the spindle's.
std::vector<TakenLine> take_lines(std::vector<double>& x, double rate);

/// One-sided density (1/Hz) of the lines at i·rate/n, i = 0…n/2, as welch() estimates it.
std::vector<double> lines_through_window(const std::vector<TakenLine>& lines, std::size_t n, double rate);

}  // namespace typodont::audio
