// Windowed sinc (Smith 1984): whole sounds offline, noise in real time.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// Kaiser window, 64 zero crossings a side, stop band -110 dB, pass band to 0.47 of the lower rate, no delay.
std::vector<double> resampled(std::span<const double> x, double from_rate, double to_rate);

/// Kernels between samples, one set per playback speed against aliasing. Constant, shared by all streams.
class InterpolationKernels {
 public:
  static constexpr int kPhases = 512;
  /// `fastest`: input samples per output sample.
  explicit InterpolationKernels(double fastest);

  /// Signal at `offset` (0 ≤ offset < 1) after *x; reads x[−reach+1 … reach].
  float read(const float* x, double offset, double speed) const noexcept;
  // samples that read() uses on each side
  int reach(double speed) const noexcept;
  int longest_reach() const noexcept { return sets_.back().taps / 2; }

 private:
  struct Set {
    double speed;  // largest speed of this set
    int taps;      // number of filter taps; a multiple of 16
    // rows of `taps` for kPhases + 1 positions between samples
    std::vector<float> rows;
  };
  const Set& set_for(double speed) const noexcept;
  std::vector<Set> sets_;
};

}  // namespace typodont::audio
