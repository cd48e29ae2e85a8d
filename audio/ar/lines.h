// Steady spectral lines of a rotor: finds them in a recording, measures them, and removes them. Not for real time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// Amplitude and frequency of one spectral line over time, one entry per kLineStep samples.
struct LineTrack {
  double frequency = 0;           // Hz, mean frequency of the spectral line
  double bandwidth = 0;           // Hz, half width (−3 dB) of the band in which the spectral line was followed
  double floor = 0;               // one-sided power density (1/Hz) of the noise next to the spectral line
  std::vector<double> amplitude;  // amplitude of the sinusoid; full scale is 1
  std::vector<double> deviation;  // Hz, deviation of the spectral line's frequency from its mean frequency

  double mean_amplitude() const;
  /// amplitude_variance_of_noise() and frequency_variance_of_noise() return the variances that the noise in the band
  /// would cause if the line itself did not fluctuate. The variance of the amplitude is divided by the square of the
  /// mean amplitude. The variance of the frequency is in Hz².
  double amplitude_variance_of_noise() const;
  double frequency_variance_of_noise() const;
  /// Returns the standard deviation of the amplitude divided by its mean: 0 for a steady sinusoid, 0.52 for noise in a
  /// narrow band.
  double variation() const;
  /// Returns variation() without the contribution of the noise next to the line.
  double own_variation() const;
  /// Returns true for a sinusoid, false for narrow-band noise (for which variation() is 0.52). True only if the noise
  /// next to the line is so weak that both cases can be distinguished.
  bool steady() const {
    return !amplitude.empty() && own_variation() < kSteadyVariation && amplitude_variance_of_noise() < kWeakestLine;
  }
  // A spectral line counts as a sinusoid if its own_variation() is at most this. The limit lies between 0 (a sinusoid)
  // and 0.52 (narrow-band noise).
  static constexpr double kSteadyVariation = 0.3;
  // Limit of a ratio: the variance that noise causes in the amplitude of the line, divided by the squared mean
  // amplitude. If the ratio is above this limit, the spectral line is too weak to be evaluated.
  static constexpr double kWeakestLine = 0.1;
};

/// Follows the line near `frequency` (Hz, an estimate) through the middle minute of the sound. Tries bands with half
/// widths of 80, 40 and 20 Hz. Uses the first band in which noise causes an amplitude variance below 0.02 of the
/// squared mean amplitude. If there is none, uses the band in which the amplitude varies least. Returns an empty track
/// if the sound is shorter than 0.2 s.
LineTrack follow_line(std::span<const double> x, double rate, double frequency);

struct TakenLine {
  ModelLine line;
  // Hz, standard deviation of the spectral line's frequency, including the drift of the spindle's speed
  double spread = 0;
  // relative variation of the spectral line's amplitude in the recording, as LineTrack::variation() returns it
  double variation = 0;
};

/// Removes the steady spectral lines from x, so that the rest can be modelled as noise. Returns at most ten lines,
/// strongest first. A change of the frequency that takes longer than a second is a change of the spindle's speed, and
/// does not count as a fluctuation of the line.
std::vector<TakenLine> take_lines(std::vector<double>& x, double rate);

/// Returns the one-sided power density (1/Hz) of the lines at the frequencies i·rate/n, i = 0…n/2, as welch() would
/// estimate it with windows of n samples.
std::vector<double> lines_through_window(const std::vector<TakenLine>& lines, std::size_t n, double rate);

}  // namespace typodont::audio
