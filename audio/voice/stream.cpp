#include "audio/voice/stream.h"

#include <cstring>

namespace typodont::audio {

ModelStream::ModelStream(const ArModel& model, double device_rate, const InterpolationKernels& kernels,
                         std::uint64_t seed)
    : filter_(model), noise_(seed), kernels_(&kernels), step_(model.rate / device_rate), samples_(kCapacity, 0.0f) {
  // Runs the filter until stationary, and discards this output.
  while (filled_ + ArFilter::kBlock <= kCapacity) refill();
  at_ = filled_ - kernels.longest_reach();
}

void ModelStream::refill() noexcept {
  if (filled_ + ArFilter::kBlock > kCapacity) {
    const int first = at_ - kernels_->longest_reach();
    std::memmove(samples_.data(), samples_.data() + first, static_cast<std::size_t>(filled_ - first) * sizeof(float));
    filled_ -= first;
    at_ -= first;
  }
  float white[ArFilter::kBlock];
  noise_.fill(white, ArFilter::kBlock);
  filter_.process(white, samples_.data() + filled_);
  filled_ += ArFilter::kBlock;
}

void ModelStream::add(const double* speed, const float* gain, float* out, int count) noexcept {
  for (int i = 0; i < count; ++i) {
    if (gain[i] == 0) continue;
    const double step = step_ * speed[i];
    while (at_ + kernels_->longest_reach() >= filled_) refill();
    const float* const x = samples_.data() + at_;
    out[i] += gain[i] * (step == 1.0 && offset_ == 0.0 ? *x : kernels_->read(x, offset_, step));
    offset_ += step;
    const int whole = static_cast<int>(offset_);
    at_ += whole;
    offset_ -= whole;
  }
}

}  // namespace typodont::audio
