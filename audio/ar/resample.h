// Resampling with a windowed sinc (Smith 1984): whole sounds offline, noise in real time.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// Resamples with a Kaiser window and 64 zero crossings per side. Stop band -110 dB; pass band up to 0.47 of the lower
/// rate; no delay.
std::vector<double> resampled(std::span<const double> x, double from_rate, double to_rate);

/// Interpolation kernels for positions between samples; one set for each range of playback speeds, against aliasing.
/// Constant, and shared by all streams.
class InterpolationKernels {
 public:
  static constexpr int kPhases = 512;
  /// `fastest`: highest speed, in input samples per output sample.
  explicit InterpolationKernels(double fastest);

  /// Value of the signal at `offset` samples (0 ≤ offset < 1) after *x; reads x[−reach+1 … reach].
  float read(const float* x, double offset, double speed) const noexcept;
  // Number of samples that read() uses on each side of the position.
  int reach(double speed) const noexcept;
  int longest_reach() const noexcept { return sets_.back().taps / 2; }

 private:
  struct Set {
    double speed;  // largest playback speed for which these kernels are used
    int taps;      // number of filter taps; a multiple of 16
    // Kernels for kPhases + 1 positions between two samples, each a row of `taps` values.
    std::vector<float> rows;
  };
  const Set& set_for(double speed) const noexcept;
  std::vector<Set> sets_;
};

}  // namespace typodont::audio
