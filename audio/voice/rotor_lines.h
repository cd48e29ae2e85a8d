// Oscillators of the models' lines; frequency ∝ speed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "audio/ar/noise.h"
#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// One value per kLineStep samples.
class RunningNoise {
 public:
  RunningNoise(const LineNoise& noise, std::uint64_t seed);
  double next() noexcept;

 private:
  GaussianNoise white_;
  double gain_;
  std::vector<double> a_;
  std::vector<double> past_;  // ring, stored twice so that a window is contiguous
  std::size_t at_ = 0;
};

/// Idle and working sound share oscillators, so a transition has no beats. Only the constructor allocates.
class RotorLines {
 public:
  /// Gain of a line in each tissue's sound.
  using Factors = std::array<float, kTissueCount>;

  explicit RotorLines(double device_rate) : rate_(device_rate) {}
  void add(const ModelLine& line, double model_rate, const Factors& factors, std::uint64_t seed);
  bool empty() const noexcept { return oscillators_.empty(); }

  static constexpr int kMost = 64;  // largest number of samples per call of add()
  /// Adds `count` ≤ kMost samples. `speeds`: relative to the recording; gains[t][i] read only if active[t]; air is
  /// idle.
  void add(const double* speeds, const float (*gains)[kMost], const bool* active, float* out, int count) noexcept;

 private:
  struct Oscillator {
    double frequency;  // Hz at the recording's speed
    float amplitude;
    Factors factors;
    RunningNoise amplitude_noise, frequency_noise;
    int step;                 // device samples between noise values
    int since = 0;            // samples since the last noise value
    std::uint32_t phase = 0;  // phase of the oscillator in units of 2^-32 turns
    /// relative amplitude deviation: last and next value
    double varies = 0, varies_next = 0;
    double wanders = 0, wanders_next = 0;  // Hz, last and next deviation of the frequency
    void add(const double* speeds, const float* power, float* out, int count, double rate) noexcept;
  };

  double rate_;
  std::vector<Oscillator> oscillators_;
};

}  // namespace typodont::audio
