// The lines of a drill's models, as oscillators that turn with the spindle.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "audio/ar/noise.h"
#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// A LineNoise on the run: one value each kLineStep samples of the model's rate.
class RunningNoise {
 public:
  RunningNoise(const LineNoise& noise, std::uint64_t seed);
  double next() noexcept;

 private:
  GaussianNoise white_;
  double gain_;
  std::vector<double> a_, past_;  // past_: a ring
  std::size_t at_ = 0;
};

/// One rotor, whatever tissue it works in: idle and working sound share the oscillators of a line, so that nothing
/// beats while one gives way to the other. Only construction allocates.
class RotorLines {
 public:
  /// How loud each line is in each tissue's sound, against its own amplitude.
  using Factors = std::array<float, kTissueCount>;

  explicit RotorLines(double device_rate) : rate_(device_rate) {}
  void add(const ModelLine& line, double model_rate, const Factors& factors, std::uint64_t seed);
  bool empty() const noexcept { return oscillators_.empty(); }

  /// Adds the next samples to `out`. `speeds`: of the recorded spindle. gains[t][i]: of tissue t's sound, read where
  /// active[t]; idle noise is tissue air's.
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
    int step;  // device samples between two values of the noises
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
