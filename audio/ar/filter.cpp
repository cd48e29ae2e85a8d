#include "audio/ar/filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "audio/ar/levinson.h"
#include "audio/ar/simd.h"
#include "engine/base/check.h"

namespace typodont::audio {

namespace {

template <class T>
struct VectorOf;
template <>
struct VectorOf<float> {
  using Aligned = Float16;
  using Unaligned = Float16Unaligned;
};
template <>
struct VectorOf<double> {
  using Aligned = Double8;
  using Unaligned = Double8Unaligned;
};

// Computes a block of 64 samples. a[1…order]: coefficients; `order` is even. y[−order…−1]: past output. response[kBlock
// + j]: impulse response at sample j, 0 for j < 0.
template <class T>
inline __attribute__((always_inline)) void block_of_64(const T* a, std::size_t order, const T* response, const T* noise,
                                                       T gain, T* y) {
  using Vector = typename VectorOf<T>::Aligned;
  using Unaligned = typename VectorOf<T>::Unaligned;
  constexpr int kLanes = static_cast<int>(sizeof(Vector) / sizeof(T));
  constexpr int kBlock = BlockFilter<T>::kBlock;
  constexpr int kSlice = 4 * kLanes;  // samples of a slice: four vectors, which stay in registers

  for (int slice = 0; slice < kBlock; slice += kSlice) {
    T* const p = y + slice;
    // Adds the contribution of earlier output samples. The samples of this slice are not known yet; they are set to
    // zero, so that every lane can multiply by all coefficients.
    std::memset(p, 0, kSlice * sizeof(T));
    Vector even[4], odd[4];
    for (int v = 0; v < 4; ++v) {
      even[v] = gain * *reinterpret_cast<const Unaligned*>(noise + slice + v * kLanes);
      odd[v] = Vector{};
    }
    // Adds the oldest samples first, because loads of the newest samples would wait until they are stored.
    for (std::size_t pair = order / 2; pair-- > 0;) {
      const std::size_t i = 2 * pair + 1;
      const T* const q = p - i;
      for (int v = 0; v < 4; ++v) {
        even[v] -= a[i] * *reinterpret_cast<const Unaligned*>(q + v * kLanes);
        odd[v] -= a[i + 1] * *reinterpret_cast<const Unaligned*>(q + v * kLanes - 1);
      }
    }
    // Contribution within the slice: convolution with the impulse response, one source vector at a time.
    T source[kSlice];
    for (int v = 0; v < 4; ++v) *reinterpret_cast<Unaligned*>(source + v * kLanes) = even[v] + odd[v];
    Vector sum[4] = {};
    for (int l = 0; l < kLanes; ++l) {
      for (int apart = 0; apart < 4; ++apart) {
        const Vector h = *reinterpret_cast<const Unaligned*>(response + kBlock + apart * kLanes - l);
        for (int v = apart; v < 4; ++v) sum[v] += source[(v - apart) * kLanes + l] * h;
      }
    }
    for (int v = 0; v < 4; ++v) *reinterpret_cast<Unaligned*>(p + v * kLanes) = sum[v];
  }
}

TYPODONT_CLONES void run_block(const float* a, std::size_t order, const float* response, const float* noise, float gain,
                               float* y) {
  block_of_64<float>(a, order, response, noise, gain, y);
}
TYPODONT_CLONES void run_block(const double* a, std::size_t order, const double* response, const double* noise,
                               double gain, double* y) {
  block_of_64<double>(a, order, response, noise, gain, y);
}

}  // namespace

double direct_form_condition(const ArModel& model) {
  double sum = 1;
  for (const double a : step_up(model.reflection)) sum += std::abs(a);
  double power = 1;
  for (const double k : model.reflection) power /= 1 - k * k;
  const double condition = sum * std::sqrt(power);
  return std::isfinite(condition) ? condition : 1e300;
}

template <class T>
DirectFilter<T>::DirectFilter(const ArModel& model) : past_(2 * std::max<std::size_t>(1, model.order()), T(0)) {
  for (const double a : step_up(model.reflection)) a_.push_back(static_cast<T>(a));
  gain_ = static_cast<T>(model.gain);
}

template <class T>
void DirectFilter<T>::process(const T* noise, T* out, int count) noexcept {
  const std::size_t order = a_.size();
  for (int n = 0; n < count; ++n) {
    T y = gain_ * noise[n];
    const T* const past = past_.data() + head_;
    for (std::size_t i = 0; i < order; ++i) y -= a_[i] * past[i];
    out[n] = y;
    if (order == 0) continue;
    head_ = head_ == 0 ? order - 1 : head_ - 1;
    past_[head_] = past_[head_ + order] = y;
  }
}

template <class T>
BlockFilter<T>::BlockFilter(const ArModel& model) : order_((model.order() + 1) / 2 * 2), a_(order_ + 2, T(0)) {
  const auto a = step_up(model.reflection);
  for (std::size_t i = 0; i < a.size(); ++i) a_[i + 1] = static_cast<T>(a[i]);
  gain_ = static_cast<T>(model.gain);
  response_.assign(2 * kBlock, T(0));
  std::vector<double> h(kBlock, 0.0);
  for (std::size_t j = 0; j < kBlock; ++j) {
    h[j] = j == 0;
    for (std::size_t i = 1; i <= std::min(j, a.size()); ++i) h[j] -= a[i - 1] * h[j - i];
    response_[kBlock + j] = static_cast<T>(h[j]);
  }
  // Each block is written after the previous one. At the buffer's end, process() copies the past output to its start.
  const std::size_t room = order_ + 4096;
  history_.assign(room + kBlock, T(0));
  at_ = order_;
}

template <class T>
void BlockFilter<T>::process(const T* noise, T* out) noexcept {
  if (at_ + kBlock > history_.size()) {
    std::memmove(history_.data(), history_.data() + at_ - order_, order_ * sizeof(T));
    at_ = order_;
  }
  T* const y = history_.data() + at_;
  run_block(a_.data(), order_, response_.data(), noise, gain_, y);
  std::memcpy(out, y, kBlock * sizeof(T));
  at_ += kBlock;
}

template class DirectFilter<float>;
template class DirectFilter<double>;
template class BlockFilter<float>;
template class BlockFilter<double>;

LatticeFilter::LatticeFilter(const ArModel& model)
    : sine_(model.order()), cosine_(model.order()), state_(model.order() + 1, 0.0) {
  set(model.reflection, std::sqrt(power_of(model)));
}

void LatticeFilter::set(const std::vector<double>& reflection, double level) noexcept {
  TYPODONT_CHECK(reflection.size() == sine_.size());
  for (std::size_t i = 0; i < sine_.size(); ++i) {
    sine_[i] = std::clamp(reflection[i], -1.0, 1.0);
    cosine_[i] = std::sqrt((1 - sine_[i]) * (1 + sine_[i]));
  }
  level_ = level;
}

double LatticeFilter::next(double noise) noexcept {
  // Lattice filter (Gray & Markel 1975, fig. 3): stage m rotates the vector (forward signal, delayed backward signal)
  // by the angle asin k_m. All signals have unit variance.
  double forward = noise;
  for (std::size_t m = sine_.size(); m-- > 0;) {
    const double backward = state_[m];
    const double next_forward = cosine_[m] * forward - sine_[m] * backward;
    state_[m + 1] = sine_[m] * forward + cosine_[m] * backward;
    forward = next_forward;
  }
  state_[0] = forward;
  return level_ * forward;
}

double LatticeFilter::energy() const noexcept {
  double sum = 0;
  for (std::size_t m = 0; m + 1 < state_.size(); ++m) sum += state_[m] * state_[m];
  return sum;
}

ArFilter::ArFilter(const ArModel& model) {
  const double condition = direct_form_condition(model);
  form_ = condition <= kFloatLimit ? Form::kFloat : condition <= kDoubleLimit ? Form::kDouble : Form::kLattice;
  if (form_ == Form::kFloat) single_ = std::make_unique<BlockFilter<float>>(model);
  if (form_ == Form::kDouble) double_ = std::make_unique<BlockFilter<double>>(model);
  if (form_ == Form::kLattice) lattice_ = std::make_unique<LatticeFilter>(model);
}

void ArFilter::process(const float* noise, float* out) noexcept {
  if (form_ == Form::kFloat) {
    single_->process(noise, out);
  } else if (form_ == Form::kDouble) {
    double wide[kBlock], filtered[kBlock];
    std::copy(noise, noise + kBlock, wide);
    double_->process(wide, filtered);
    for (int i = 0; i < kBlock; ++i) out[i] = static_cast<float>(filtered[i]);
  } else {
    for (int i = 0; i < kBlock; ++i) out[i] = static_cast<float>(lattice_->next(noise[i]));
  }
}

}  // namespace typodont::audio
