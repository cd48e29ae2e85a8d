// Oscillators for the spectral lines of the models; their frequency is proportional to the speed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "audio/ar/noise.h"
#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Generates the random process LineNoise: one value per kLineStep samples.
class RunningNoise {
 public:
  RunningNoise(const LineNoise& noise, std::uint64_t seed);
  double next() noexcept;

 private:
  GaussianNoise white_;
  double gain_;
  std::vector<double> a_;
  std::vector<double> past_;  // ring buffer, stored twice so that past values are contiguous
  std::size_t at_ = 0;
};

/// Idle sound and cutting sound use the same oscillators, so that no beats are heard in transitions. Only the
/// constructor allocates.
class RotorLines {
 public:
  /// Gain of a line in each tissue's sound.
  using Factors = std::array<float, kTissueCount>;

  explicit RotorLines(double device_rate) : rate_(device_rate) {}
  void add(const ModelLine& line, double model_rate, const Factors& factors, std::uint64_t seed);
  bool empty() const noexcept { return oscillators_.empty(); }

  static constexpr int kMost = 64;  // largest number of samples per call of add()
  /// Adds `count` ≤ kMost samples. `speeds`: spindle speed divided by the speed in the recording. gains[t][i]: gain of
  /// tissue t at sample i, read only if active[t]; air is the idle sound.
  void add(const double* speeds, const float (*gains)[kMost], const bool* active, float* out, int count) noexcept;

 private:
  struct Oscillator {
    double frequency;  // Hz, frequency at the speed of the recording
    float amplitude;
    Factors factors;
    RunningNoise amplitude_noise, frequency_noise;
    int step;                 // number of samples between two noise values
    int since = 0;            // number of samples since the last noise value
    std::uint32_t phase = 0;  // phase of the oscillator in units of 2^-32 turns
    /// Random relative deviation of the amplitude: previous and next value.
    double varies = 0, varies_next = 0;
    double wanders = 0, wanders_next = 0;  // Hz, random deviation of the frequency: previous and next value
    void add(const double* speeds, const float* power, float* out, int count, double rate) noexcept;
  };

  double rate_;
  std::vector<Oscillator> oscillators_;
};

}  // namespace typodont::audio
