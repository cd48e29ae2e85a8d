// The endless sound of one model, played at a variable speed.
#pragma once

#include <cstdint>
#include <vector>

#include "audio/ar/filter.h"
#include "audio/ar/noise.h"
#include "audio/ar/resample.h"

namespace typodont::audio {

/// Filters white noise at the model's own rate, then interpolates the result to the device's rate times the playback
/// speed. All parts of the spectrum shift together, as they do when a rotor slows down. Nothing is computed unless it
/// is read.
class ModelStream {
 public:
  /// `kernels` must outlive the stream and cover the highest playback speed.
  ModelStream(const ArModel& model, double device_rate, const InterpolationKernels& kernels, std::uint64_t seed);

  /// Adds gain[i] times the next sample, played at speed[i] (1: as recorded), to out[i]. While the gain is zero, the
  /// playback position does not move.
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
  double offset_ = 0;  // 0 … 1, distance of the playback position from sample at_
};

}  // namespace typodont::audio
