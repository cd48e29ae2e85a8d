// Sample-rate conversion by windowed sinc (Smith 1984), for whole sounds (not in real time) and for noise while it is
// generated (in real time).
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// Converts a whole sound to another sampling rate. Kaiser window, 64 zero crossings on each side, stop band below -110
/// dB. The pass band ends at 0.47 of the lower of the two rates. No delay. Not for real time.
std::vector<double> resampled(std::span<const double> x, double from_rate, double to_rate);

/// Interpolation kernels that evaluate a sampled signal between its samples. There is one set per playback speed, with
/// a cut-off that prevents aliasing at that speed. Shared by all streams of a synthesizer; constant after construction.
class InterpolationKernels {
 public:
  static constexpr int kPhases = 512;
  /// Computes the kernels for playback speeds up to `fastest` (input samples per output sample).
  explicit InterpolationKernels(double fastest);

  /// Returns the signal at `offset` (0 ≤ offset < 1) samples after *x, for playback at `speed`. Reads x[−reach+1 …
  /// reach].
  float read(const float* x, double offset, double speed) const noexcept;
  // returns the number of samples that read() uses on each side of the position
  int reach(double speed) const noexcept;
  int longest_reach() const noexcept { return sets_.back().taps / 2; }

 private:
  struct Set {
    double speed;  // the highest playback speed for which this set of kernels is used
    int taps;      // number of filter taps; a multiple of 16
    // filter coefficients: one row of `taps` values for each of kPhases + 1 positions between two samples
    std::vector<float> rows;
  };
  const Set& set_for(double speed) const noexcept;
  std::vector<Set> sets_;
};

}  // namespace typodont::audio
