// From one sampling rate to another by windowed sinc (Smith 1984): whole sounds at set-up, noise on the run.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// A whole sound at another rate: Kaiser window, 64 zero crossings to a side, stop band under -110 dB; the pass band
/// ends at 0.47 of the lower rate. Delay-free. Set-up time.
std::vector<double> resampled(std::span<const double> x, double from_rate, double to_rate);

/// Interpolation kernels for reading samples at any place between them, one set per reading speed, so that reading
/// faster does not fold. Shared by all streams of a synthesizer; constant after construction.
class InterpolationKernels {
 public:
  static constexpr int kPhases = 512;
  /// For reading speeds up to `fastest` samples per sample.
  explicit InterpolationKernels(double fastest);

  /// Where the sound lies `offset` (0 ≤ offset < 1) after *x, read at `speed`: x[−reach+1 … reach] are looked at.
  float read(const float* x, double offset, double speed) const noexcept;
  int reach(double speed) const noexcept;  // samples to either side
  int longest_reach() const noexcept { return sets_.back().taps / 2; }

 private:
  struct Set {
    double speed;             // up to which it is used
    int taps;                 // a multiple of 16
    std::vector<float> rows;  // (kPhases + 1) × taps
  };
  const Set& set_for(double speed) const noexcept;
  std::vector<Set> sets_;
};

}  // namespace typodont::audio
