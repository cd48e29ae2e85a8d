// All-pole filters 1/A(z), in three forms of one thing. None allocates after construction.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "audio/ar_model.h"

namespace typodont::audio {

/// How ill-conditioned the direct form is: Σ|a| times the output's standard deviation over the residual's. Rounding
/// enters the direct recursion like a second excitation, about (machine epsilon × this) times the true one.
double direct_form_condition(const ArModel& model);

/// The plain loop, for comparison: y[n] = gain·e[n] − Σ a_i y[n−i].
template <class T>
class DirectFilter {
 public:
  explicit DirectFilter(const ArModel& model);
  void process(const T* noise, T* out, int count) noexcept;

 private:
  std::vector<T> a_, past_;  // past_: order newest samples, newest first, written twice so that it never wraps
  T gain_;
  std::size_t head_ = 0;
};

/// Sixty-four samples at once: what the past contributes is a convolution over independent lanes; what the block
/// contributes to itself is solved by the first 64 samples of the impulse response, which is the inverse of the
/// triangular system of the block.
template <class T>
class BlockFilter {
 public:
  static constexpr int kBlock = 64;
  explicit BlockFilter(const ArModel& model);
  /// kBlock samples.
  void process(const T* noise, T* out) noexcept;

 private:
  std::size_t order_;  // padded to a multiple of 2
  std::vector<T> a_, response_, history_;
  T gain_;
  std::size_t at_;  // where the next block goes in history_
};

/// Normalised lattice (Gray & Markel 1975): each stage is a rotation, so the states' energy never exceeds what went in,
/// for any path of the coefficients inside |k| ≤ 1. `level` is the output's standard deviation.
class LatticeFilter {
 public:
  explicit LatticeFilter(const ArModel& model);

  double next(double noise) noexcept;
  /// Jumps to other coefficients of the same order between two samples; states are kept.
  void set(const std::vector<double>& reflection, double level) noexcept;
  double energy() const noexcept;  // Σ of the states' squares
  double level() const noexcept { return level_; }

 private:
  std::vector<double> sine_, cosine_, state_;
  double level_;
};

/// The form that suits the model: blocks in float, blocks in double, or the lattice, by direct_form_condition.
class ArFilter {
 public:
  static constexpr int kBlock = 64;
  static constexpr double kFloatLimit = 4e3;    // rounding 70 dB under the excitation
  static constexpr double kDoubleLimit = 1e10;  // rounding 110 dB under it; beyond, the lattice
  enum class Form { kFloat, kDouble, kLattice };

  explicit ArFilter(const ArModel& model);
  void process(const float* noise, float* out) noexcept;  // kBlock samples
  Form form() const noexcept { return form_; }

 private:
  Form form_;
  std::unique_ptr<BlockFilter<float>> single_;
  std::unique_ptr<BlockFilter<double>> double_;
  std::unique_ptr<LatticeFilter> lattice_;
};

}  // namespace typodont::audio
