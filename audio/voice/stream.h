// Endless sound of one model, played at variable speed.
#pragma once

#include <cstdint>
#include <vector>

#include "audio/ar/filter.h"
#include "audio/ar/noise.h"
#include "audio/ar/resample.h"

namespace typodont::audio {

/// Noise is filtered at the model's sampling rate and then interpolated, so the whole spectrum moves with the rotor's
/// speed. Samples are computed only when they are read.
class ModelStream {
 public:
  /// `kernels` must outlive the stream, and be made for at least the highest speed of playback.
  ModelStream(const ArModel& model, double device_rate, const InterpolationKernels& kernels, std::uint64_t seed);

  /// Adds gain[i] × sample to out[i], played at speed[i] (1: as recorded). While the gain is zero, playback stands
  /// still.
  void add(const double* speed, const float* gain, float* out, int count) noexcept;

 private:
  void refill() noexcept;

  static constexpr int kCapacity = 8192;
  ArFilter filter_;
  GaussianNoise noise_;
  const InterpolationKernels* kernels_;
  double step_;  // number of samples of the model per sample of the device, at speed 1
  std::vector<float> samples_;
  int filled_ = 0;
  int at_ = 0;         // index of the model's sample before the playback position
  double offset_ = 0;  // position after sample at_, 0 … 1
};

}  // namespace typodont::audio
