// All-pole filters 1/A(z): direct form, block form and normalised lattice. They do not allocate memory after
// construction.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// Returns the condition number of the direct form: Σ|a| times the ratio of the standard deviations of output and
/// residual. Rounding errors in the direct form act like an additional excitation. The ratio of this excitation to the
/// true excitation is the machine epsilon times the condition number.
double direct_form_condition(const ArModel& model);

/// Reference implementation, a plain loop: y[n] = gain·e[n] − Σ a_i y[n−i]. e: noise; y: output; a_i: coefficients of
/// the model.
template <class T>
class DirectFilter {
 public:
  explicit DirectFilter(const ArModel& model);
  void process(const T* noise, T* out, int count) noexcept;

 private:
  // past_ contains the newest `order` samples, newest first. Every sample is stored twice, so that `order` consecutive
  // elements can always be read without a wrap at the end of the buffer.
  std::vector<T> a_, past_;
  T gain_;
  std::size_t head_ = 0;
};

/// Computes the recursive filter in blocks of 64 samples, so that SIMD instructions can be used. First, the
/// contribution of earlier blocks to all 64 samples is computed as a convolution. Within the block, each sample depends
/// on the samples before it, which is a triangular system of equations. The block is therefore multiplied by the
/// inverse matrix, whose elements are the first 64 samples of the impulse response.
template <class T>
class BlockFilter {
 public:
  static constexpr int kBlock = 64;
  explicit BlockFilter(const ArModel& model);
  /// Filters the next kBlock samples: the noise drives the filter, and `out` receives its output.
  void process(const T* noise, T* out) noexcept;

 private:
  std::size_t order_;  // the model's order, padded to a multiple of 2
  std::vector<T> a_, response_, history_;
  T gain_;
  std::size_t at_;  // index in history_ where the next block is written
};

/// Normalised lattice (Gray & Markel 1975). Each stage is a rotation. So, as long as |k| ≤ 1, the energy of the states
/// never exceeds the energy of the input, even while the coefficients change. `level` is the standard deviation of the
/// output.
class LatticeFilter {
 public:
  explicit LatticeFilter(const ArModel& model);

  double next(double noise) noexcept;
  /// Sets new reflection coefficients and a new level, between two samples. The order and the states of the filter stay
  /// the same.
  void set(const std::vector<double>& reflection, double level) noexcept;
  double energy() const noexcept;  // returns the sum of the squared states of the filter
  double level() const noexcept { return level_; }

 private:
  std::vector<double> sine_, cosine_, state_;
  double level_;
};

/// Chooses the form of the filter by direct_form_condition(): the block form in float, the block form in double, or the
/// lattice.
class ArFilter {
 public:
  static constexpr int kBlock = 64;
  /// Largest condition number for which the block form in float is used. At this value, the rounding noise is 70 dB
  /// below the excitation.
  static constexpr double kFloatLimit = 4e3;
  /// Largest condition number for which the block form in double is used. At this value, the rounding noise is 110 dB
  /// below the excitation. If the number is larger, the lattice form is used.
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
