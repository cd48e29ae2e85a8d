// Oscillators for the spectral lines of a drill's models; their frequency is proportional to the spindle's speed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "audio/ar/noise.h"
#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Generates a LineNoise (a slow random process): one value per kLineStep samples of the model's rate.
class RunningNoise {
 public:
  RunningNoise(const LineNoise& noise, std::uint64_t seed);
  double next() noexcept;

 private:
  GaussianNoise white_;
  double gain_;
  std::vector<double> a_;
  std::vector<double> past_;  // ring buffer; every value is stored twice, so that a window of the buffer is contiguous
  std::size_t at_ = 0;
};

/// The spectral lines of one rotor. Idle and working sounds share the oscillator of a line, so that a transition
/// between them causes no beats. Only the constructor allocates.
class RotorLines {
 public:
  /// Gain of a spectral line in each tissue's sound, as a ratio to the line's amplitude.
  using Factors = std::array<float, kTissueCount>;

  explicit RotorLines(double device_rate) : rate_(device_rate) {}
  void add(const ModelLine& line, double model_rate, const Factors& factors, std::uint64_t seed);
  bool empty() const noexcept { return oscillators_.empty(); }

  static constexpr int kMost = 64;  // largest number of samples per call of add()
  /// Adds the next `count` samples, at most kMost, of all lines to `out`. `speeds`: for each sample, the ratio of the
  /// spindle's speed to its speed in the recording. gains[t][i]: gain of tissue t's sound at sample i, read only if
  /// active[t]. The idle sound is that of tissue air.
  void add(const double* speeds, const float (*gains)[kMost], const bool* active, float* out, int count) noexcept;

 private:
  struct Oscillator {
    double frequency;  // Hz, frequency if the spindle has the speed of the recording
    float amplitude;
    Factors factors;
    RunningNoise amplitude_noise, frequency_noise;
    int step;                 // number of device samples between two values of the line noises
    int since = 0;            // number of samples since the last value of the line noises was computed
    std::uint32_t phase = 0;  // phase of the oscillator in units of 2^-32 turns
    /// relative deviation of the spectral line's amplitude: last and next value of its noise; interpolated in between
    double varies = 0, varies_next = 0;
    double wanders = 0, wanders_next = 0;  // Hz, last and next value of the deviation of the frequency
    void add(const double* speeds, const float* power, float* out, int count, double rate) noexcept;
  };

  double rate_;
  std::vector<Oscillator> oscillators_;
};

}  // namespace typodont::audio
