// A rotor's steady lines: found in a recording, measured, and taken out of it. Set-up time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// How a line of a sound goes over time: one entry per kLineStep samples.
struct LineTrack {
  double frequency = 0;           // Hz, mean
  double bandwidth = 0;           // Hz to either side at which the band that was followed has lost 3 dB
  double floor = 0;               // one-sided power density (1/Hz) of the noise beside the line
  std::vector<double> amplitude;  // of the sinusoid, full scale 1
  std::vector<double> deviation;  // Hz from the mean frequency

  double mean_amplitude() const;
  /// Variance of the amplitude, relative to its mean's square, and of the frequency (Hz²) that the noise in the band
  /// alone would make.
  double amplitude_variance_of_noise() const;
  double frequency_variance_of_noise() const;
  /// Standard deviation of the amplitude over its mean: 0 for a steady sinusoid, 0.52 for noise in a narrow band.
  double variation() const;
  /// The same without what the noise beside the line adds.
  double own_variation() const;
  /// A sinusoid rather than noise in a narrow band: its amplitude varies by less than halfway between the two.
  bool steady() const { return !amplitude.empty() && variation() < 0.3; }
};

/// Follows the line at `frequency`, which need not be exact, in the middle minute of the sound. Among bandwidths of 20
/// to 160 Hz it takes the widest in which the noise is weak (its variance at most 0.02 of the line's), else the one in
/// which the amplitude varies least. Empty where the sound is shorter than 0.2 s.
LineTrack follow_line(std::span<const double> x, double rate, double frequency);

struct TakenLine {
  ModelLine line;
  double spread = 0;  // Hz, standard deviation of its frequency in the recording, the drift of the spindle included
};

/// Takes the steady lines out of x: what stays is to be modelled as noise. Strongest first, at most 16. A line's
/// frequency varies by its own deviations only; what changes over a second is the spindle's speed.
std::vector<TakenLine> take_lines(std::vector<double>& x, double rate);

/// One-sided power density (1/Hz) of the lines in the recording at i·rate/n, i = 0…n/2, as welch() shows it with
/// windows of n samples.
std::vector<double> lines_through_window(const std::vector<TakenLine>& lines, std::size_t n, double rate);

}  // namespace typodont::audio
