// Spectrum of a sound over time (FFTW). Not for real time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

struct Spectrogram {
  double f_step = 0;       // Hz, width of a frequency bin; bin 0 is at 0 Hz
  std::size_t frames = 0;  // number of frames, spread evenly over the whole sound
  std::size_t bins = 0;
  /// Power density of each bin, frame after frame, dB re full scale² per Hz.
  std::vector<float> dB;

  float at(std::size_t frame, std::size_t bin) const { return dB[frame * bins + bin]; }
};

/// Computes the mean power of each frame's part of the sound, or of about `window` (s) around its middle if the part is
/// shorter.
Spectrogram spectrogram(std::span<const double> sound, double rate, std::size_t frames, double window = 0.04);

}  // namespace typodont::audio
