// The spectrum of a sound over time, computed with FFTW. Not for real-time threads.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

struct Spectrogram {
  double f_step = 0;       // Hz, distance between neighbouring bins; bin 0 is at 0 Hz
  std::size_t frames = 0;  // number of frames, spread evenly over the whole sound
  std::size_t bins = 0;
  /// dB re full scale² per Hz, power density: all bins of the first frame, then all bins of the second frame, …
  std::vector<float> dB;

  float at(std::size_t frame, std::size_t bin) const { return dB[frame * bins + bin]; }
};

/// Computes the spectrogram. `rate`: Hz, sampling rate. Each frame is the mean power over its part of the sound. If
/// this part is shorter than `window` (s), the mean is over about `window` around the middle of the part.
Spectrogram spectrogram(std::span<const double> sound, double rate, std::size_t frames, double window = 0.04);

}  // namespace typodont::audio
