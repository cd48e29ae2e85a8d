// One model's endless sound, read at any speed.
#pragma once

#include <cstdint>
#include <vector>

#include "audio/ar/filter.h"
#include "audio/ar/noise.h"
#include "audio/ar/resample.h"

namespace typodont::audio {

/// White noise through the model's filter at the model's own rate, and from there to the device's rate times the speed
/// by interpolation: lines and body move together, as they do when a rotor slows down. Reading every sample once, it
/// costs the filter only. Nothing runs unless it is read.
class ModelStream {
 public:
  /// `kernels` outlives the stream and covers the fastest speed it is read at.
  ModelStream(const ArModel& model, double device_rate, const InterpolationKernels& kernels, std::uint64_t seed);

  /// Adds gain[i] times the next sample read at speed[i] (1: as recorded) to out[i]. Where the gain is zero the
  /// sound stands still.
  void add(const double* speed, const float* gain, float* out, int count) noexcept;

 private:
  void refill() noexcept;

  static constexpr int kCapacity = 8192;
  ArFilter filter_;
  GaussianNoise noise_;
  const InterpolationKernels* kernels_;
  double step_;  // source samples per device sample at speed 1
  std::vector<float> samples_;
  int filled_ = 0;
  int at_ = 0;         // the sample before the reading place
  double offset_ = 0;  // of the reading place from it, 0 … 1
};

}  // namespace typodont::audio
