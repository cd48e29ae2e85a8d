// All-pole filters 1/A(z) in direct, block and lattice form. Only constructors allocate.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// Condition number Σ|a| · σ(output) / σ(residual). Multiplied by the machine epsilon, it is the relative rounding
/// error of the direct form.
double direct_form_condition(const ArModel& model);

/// Reference implementation: y[n] = gain·e[n] − Σ a_i y[n−i].
template <class T>
class DirectFilter {
 public:
  explicit DirectFilter(const ArModel& model);
  void process(const T* noise, T* out, int count) noexcept;

 private:
  // a_: coefficients. past_: the newest `order` outputs, newest first, stored twice so that they are always contiguous
  // in memory.
  std::vector<T> a_, past_;
  T gain_;
  std::size_t head_ = 0;
};

/// Filters blocks of 64 samples. Past output contributes through the coefficients; the feedback within each part of a
/// block is a convolution with the impulse response.
template <class T>
class BlockFilter {
 public:
  static constexpr int kBlock = 64;
  explicit BlockFilter(const ArModel& model);
  /// Filters the kBlock samples of `noise`.
  void process(const T* noise, T* out) noexcept;

 private:
  std::size_t order_;  // the model's order, rounded up to a multiple of 2
  std::vector<T> a_, response_, history_;
  T gain_;
  std::size_t at_;  // index in history_ at which the next block of output is written
};

/// Normalised lattice filter (Gray & Markel 1975). Rotations keep the energy bounded for |k| ≤ 1, also while k changes.
/// `level`: standard deviation of the output.
class LatticeFilter {
 public:
  explicit LatticeFilter(const ArModel& model);

  double next(double noise) noexcept;
  /// Changes the coefficients between two samples. Keeps the filter's order and its past samples.
  void set(const std::vector<double>& reflection, double level) noexcept;
  double energy() const noexcept;  // returns the sum of the squared states of the filter
  double level() const noexcept { return level_; }

 private:
  std::vector<double> sine_, cosine_, state_;
  double level_;
};

/// A filter in the simplest form that is accurate enough: float, double or lattice (see direct_form_condition()).
class ArFilter {
 public:
  static constexpr int kBlock = 64;
  /// Largest condition number for float: rounding noise is then 70 dB below the excitation.
  static constexpr double kFloatLimit = 4e3;
  /// Largest condition number for double: rounding noise is then 110 dB below the excitation. Above it: lattice form.
  static constexpr double kDoubleLimit = 1e10;
  enum class Form { kFloat, kDouble, kLattice };

  explicit ArFilter(const ArModel& model);
  void process(const float* noise, float* out) noexcept;  // filters the next kBlock samples of noise into `out`
  Form form() const noexcept { return form_; }

 private:
  Form form_;
  std::unique_ptr<BlockFilter<float>> single_;
  std::unique_ptr<BlockFilter<double>> double_;
  std::unique_ptr<LatticeFilter> lattice_;
};

}  // namespace typodont::audio
