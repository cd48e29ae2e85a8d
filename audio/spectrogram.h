// Spectrum over time (FFTW). Not for real time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

struct Spectrogram {
  double f_step = 0;       // Hz; bin 0 is 0 Hz
  std::size_t frames = 0;  // number of frames, spread evenly over the whole sound
  std::size_t bins = 0;
  /// dB re full scale² per Hz, frame after frame
  std::vector<float> dB;

  float at(std::size_t frame, std::size_t bin) const { return dB[frame * bins + bin]; }
};

/// Frames: mean power of their part, or of about `window` (s) around its middle.
Spectrogram spectrogram(std::span<const double> sound, double rate, std::size_t frames, double window = 0.04);

}  // namespace typodont::audio
