// One model's endless sound at a variable speed.
#pragma once

#include <cstdint>
#include <vector>

#include "audio/ar/filter.h"
#include "audio/ar/noise.h"
#include "audio/ar/resample.h"

namespace typodont::audio {

/// Noise filtered at the model's rate, then interpolated: the whole spectrum shifts with the rotor. Computed only as
/// read.
class ModelStream {
 public:
  /// `kernels` outlives the stream and covers its highest speed.
  ModelStream(const ArModel& model, double device_rate, const InterpolationKernels& kernels, std::uint64_t seed);

  /// out[i] += gain[i] × sample at speed[i] (1: as recorded). The position rests while the gain is zero.
  void add(const double* speed, const float* gain, float* out, int count) noexcept;

 private:
  void refill() noexcept;

  static constexpr int kCapacity = 8192;
  ArFilter filter_;
  GaussianNoise noise_;
  const InterpolationKernels* kernels_;
  double step_;  // number of model samples per device sample at speed 1
  std::vector<float> samples_;
  int filled_ = 0;
  int at_ = 0;         // index of the sample before the playback position
  double offset_ = 0;  // 0 … 1 after sample at_
};

}  // namespace typodont::audio
