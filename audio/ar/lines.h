// Finds, measures and removes steady spectral lines of a rotor. Not for real time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// A spectral line over time, one value per kLineStep samples.
struct LineTrack {
  double frequency = 0;           // Hz, mean frequency of the spectral line
  double bandwidth = 0;           // Hz, half width (−3 dB) of the band around the line
  double floor = 0;               // one-sided power density beside the line, 1/Hz
  std::vector<double> amplitude;  // amplitude of the sinusoid; full scale is 1
  std::vector<double> deviation;  // Hz, deviation from the mean frequency

  double mean_amplitude() const;
  /// Variances that noise alone would cause: of the amplitude (relative to its squared mean), of the frequency (Hz²).
  double amplitude_variance_of_noise() const;
  double frequency_variance_of_noise() const;
  /// Standard deviation of the amplitude divided by its mean: 0 for a sinusoid, 0.52 for narrow-band noise.
  double variation() const;
  /// variation() without the part caused by noise beside the line.
  double own_variation() const;
  /// Returns true for a sinusoid that noise does not mask.
  bool steady() const {
    return !amplitude.empty() && own_variation() < kSteadyVariation && amplitude_variance_of_noise() < kWeakestLine;
  }
  // Below this own_variation(), a line counts as a sinusoid.
  static constexpr double kSteadyVariation = 0.3;
  // Largest amplitude variance caused by noise, relative to the squared mean amplitude; above it, the line is too weak.
  static constexpr double kWeakestLine = 0.1;
};

/// Follows the line near `frequency` (Hz); in a sound longer than a minute, only its middle minute. Tries the half
/// widths 80, 40, 20 Hz until noise causes an amplitude variance below 0.02. Empty for sounds below 0.2 s.
LineTrack follow_line(std::span<const double> x, double rate, double frequency);

struct TakenLine {
  ModelLine line;
  // Standard deviation of the line's frequency, including the drift of the spindle's speed, Hz.
  double spread = 0;
  // Standard deviation of the line's amplitude divided by its mean (LineTrack::variation()).
  double variation = 0;
};

/// Removes the steady lines from x, at most ten, the strongest first. Frequency changes that take longer than a second
/// count as changes of the spindle's speed.
std::vector<TakenLine> take_lines(std::vector<double>& x, double rate);

/// One-sided density (1/Hz) of the lines, as welch() would estimate it, at the frequencies i·rate/n, i = 0…n/2.
std::vector<double> lines_through_window(const std::vector<TakenLine>& lines, std::size_t n, double rate);

}  // namespace typodont::audio
