// Oscillators for the spectral lines of a drill's models; their frequency is proportional to the spindle's speed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "audio/ar/noise.h"
#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Generates a LineNoise: one value per kLineStep samples of the model's rate.
class RunningNoise {
 public:
  RunningNoise(const LineNoise& noise, std::uint64_t seed);
  double next() noexcept;

 private:
  GaussianNoise white_;
  double gain_;
  std::vector<double> a_, past_;  // past_: ring buffer
  std::size_t at_ = 0;
};

/// The lines of one rotor. Idle and working sounds share the oscillator of a line, so that a transition between them
/// causes no beats. Only the constructor allocates.
class RotorLines {
 public:
  /// Gain of a line in each tissue's sound, as a ratio to the line's amplitude.
  using Factors = std::array<float, kTissueCount>;

  explicit RotorLines(double device_rate) : rate_(device_rate) {}
  void add(const ModelLine& line, double model_rate, const Factors& factors, std::uint64_t seed);
  bool empty() const noexcept { return oscillators_.empty(); }

  /// Adds the next samples to `out`. `speeds`: spindle speed over the recorded speed. gains[t][i]: gain of tissue t's
  /// sound, read only if active[t]. The idle sound is that of tissue air.
  template <std::size_t kLength>
  void add(const double* speeds, const float (*gains)[kLength], const bool* active, float* out, int count) noexcept {
    for (Oscillator& o : oscillators_) {
      for (int i = 0; i < count; ++i) {
        float power = 0;
        for (std::size_t t = 0; t < kTissueCount; ++t) {
          if (active[t]) power += square(gains[t][i] * o.factors[t]);
        }
        out[i] += o.next(speeds[i], power, rate_);
      }
    }
  }

 private:
  static float square(float x) noexcept { return x * x; }

  struct Oscillator {
    double frequency;  // Hz at speed 1
    float amplitude;
    Factors factors;
    RunningNoise amplitude_noise, frequency_noise;
    int step;  // device samples between two values of the line noises
    int left = 0;
    double phase = 0;                      // turns
    double varies = 0, varies_step = 0;    // relative amplitude, and its change per sample
    double wanders = 0, wanders_step = 0;  // Hz
    float next(double speed, float power, double rate) noexcept;
  };

  double rate_;
  std::vector<Oscillator> oscillators_;
};

}  // namespace typodont::audio
