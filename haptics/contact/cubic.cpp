#include "haptics/contact/cubic.h"

#include "haptics/cutting/lanes.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define TYPODONT_WIDE_CUBIC 1
#include <immintrin.h>
#endif

// All functions with vector arguments are inlined, so the warning about their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace typodont::haptics {

namespace {

typedef double D2 __attribute__((vector_size(16), aligned(8), may_alias));

constexpr int kLead = 2;  // number of samples at the start of a row that have the weight zero

/// Weight and derivative of each sample of a row, as polynomials in the fraction 0..1.
struct Polynomials {
  alignas(64) double value[4][8] = {}, slope[3][8] = {};
};

/// Weights of the samples i-2 to i+3 for a point between i and i+1: cubic B-spline convolved with (-1, 8, -1)/6.
constexpr Polynomials weights() {
  // Cubic B-spline × 6. Row: sample; column: power 0 to 3 of the fraction.
  constexpr double kSpline[4][4] = {{1, -3, 3, -1}, {4, 0, -6, 3}, {1, 3, 3, -3}, {0, 0, 0, 1}};
  Polynomials p;
  for (int j = 0; j < 6; ++j) {
    for (int power = 0; power < 4; ++power) {
      const auto spline = [&](int k) { return k < 0 || k > 3 ? 0.0 : kSpline[k][power]; };
      p.value[power][kLead + j] = (8 * spline(j - 1) - spline(j) - spline(j - 2)) / 36;
      if (power > 0) p.slope[power - 1][kLead + j] = power * p.value[power][kLead + j];
    }
  }
  return p;
}

// Adding kGrid rounds a double below 2 to a multiple of 2^-29. Products of such multiples with floats are exact.
constexpr double kGrid = 1.5 * (1 << 23);

/// For each sample j, sums of the weights from j to the last sample. A weight is the difference of two rounded sums, so
/// all weights add up to exactly 1 (their derivatives to 0).
constexpr Polynomials sums() {
  const Polynomials of_each = weights();
  Polynomials p;
  for (int j = 0; j < 8; ++j) {
    for (int power = 0; power < 4; ++power) {
      double sum = 0;
      for (int k = j; k < 8; ++k) sum += of_each.value[power][k];
      if (j <= kLead) sum = power == 0 ? 1 : 0;
      p.value[power][j] = sum;
      if (power > 0) p.slope[power - 1][j] = power * sum;
    }
    p.value[0][j] += kGrid;
    p.slope[0][j] += kGrid;
  }
  return p;
}

constexpr Polynomials kWeights = weights(), kSums = sums();

}  // namespace

namespace by_two {
namespace {

using Lanes = D2;
constexpr int kLanes = 2;

TYPODONT_INLINE Lanes widened(const float* p) {
  return Lanes{p[0], p[1]};
}
TYPODONT_INLINE Lanes exact_product_added(const Lanes& a, double b, const Lanes& sum) {
  return sum + a * b;
}
TYPODONT_INLINE Lanes one_on(const Lanes& v, const Lanes& after) {
  return __builtin_shufflevector(v, after, 1, 2);
}
TYPODONT_INLINE void add_by_fours(const Lanes& v, int at, double* sums) {
  *reinterpret_cast<D2*>(sums + at % 4) += v;
}
TYPODONT_INLINE void add_across(const double (&sums)[4][4], double* out) {
  for (int k = 0; k < 4; ++k) out[k] = (sums[k][0] + sums[k][1]) + (sums[k][2] + sums[k][3]);
}
#include "haptics/contact/cubic_kernel.h"

}  // namespace
}  // namespace by_two

#ifdef TYPODONT_WIDE_CUBIC
/// Adds four rows of four partial sums at once.
#define TYPODONT_ADD_ACROSS                                                                                         \
  TYPODONT_INLINE void add_across(const double(&sums)[4][4], double* out) {                                         \
    const D4* const s = reinterpret_cast<const D4*>(sums);                                                          \
    const D4 a = __builtin_shufflevector(s[0], s[1], 0, 4, 2, 6) + __builtin_shufflevector(s[0], s[1], 1, 5, 3, 7); \
    const D4 b = __builtin_shufflevector(s[2], s[3], 0, 4, 2, 6) + __builtin_shufflevector(s[2], s[3], 1, 5, 3, 7); \
    *reinterpret_cast<D4*>(out) =                                                                                   \
        __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);                      \
  }

#pragma GCC push_options
#pragma GCC target("arch=x86-64-v3")
namespace by_four {
namespace {

using Lanes = D4;
constexpr int kLanes = 4;

TYPODONT_INLINE Lanes widened(const float* p) {
  return (Lanes)_mm256_cvtps_pd(_mm_loadu_ps(p));
}
TYPODONT_INLINE Lanes exact_product_added(const Lanes& a, double b, const Lanes& sum) {
  return (Lanes)_mm256_fmadd_pd((__m256d)a, _mm256_set1_pd(b), (__m256d)sum);
}
TYPODONT_INLINE Lanes one_on(const Lanes& v, const Lanes& after) {
  return __builtin_shufflevector(v, after, 1, 2, 3, 4);
}
TYPODONT_INLINE void add_by_fours(const Lanes& v, int, double* sums) {
  *reinterpret_cast<D4*>(sums) += v;
}
TYPODONT_ADD_ACROSS
#include "haptics/contact/cubic_kernel.h"

}  // namespace
}  // namespace by_four
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
namespace by_eight {
namespace {

using Lanes = D8;
constexpr int kLanes = 8;

// Uses the masked instruction, because GCC 12 warns wrongly about the unmasked one.
TYPODONT_INLINE Lanes widened(const float* p) {
  return (Lanes)_mm512_maskz_cvtps_pd(0xff, _mm256_loadu_ps(p));
}
TYPODONT_INLINE Lanes exact_product_added(const Lanes& a, double b, const Lanes& sum) {
  return (Lanes)_mm512_fmadd_pd((__m512d)a, _mm512_set1_pd(b), (__m512d)sum);
}
TYPODONT_INLINE Lanes one_on(const Lanes& v, const Lanes& after) {
  return __builtin_shufflevector(v, after, 1, 2, 3, 4, 5, 6, 7, 8);
}
TYPODONT_INLINE void add_by_fours(const Lanes& v, int, double* sums) {
  *reinterpret_cast<D4*>(sums) = __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
}
TYPODONT_ADD_ACROSS
#include "haptics/contact/cubic_kernel.h"

}  // namespace
}  // namespace by_eight
#pragma GCC pop_options
#undef TYPODONT_ADD_ACROSS
#endif

int widest_cubic() noexcept {
#ifdef TYPODONT_WIDE_CUBIC
  if (__builtin_cpu_supports("x86-64-v4")) return by_eight::kLanes;
  if (__builtin_cpu_supports("x86-64-v3")) return by_four::kLanes;
#endif
  return by_two::kLanes;
}

void cubic(const float* corner, std::size_t stride_x, std::size_t stride_y, const double* fractions, double* out,
           int lanes) noexcept {
#ifdef TYPODONT_WIDE_CUBIC
  if (lanes == by_eight::kLanes) return by_eight::cubic(corner, stride_x, stride_y, fractions, out);
  if (lanes == by_four::kLanes) return by_four::cubic(corner, stride_x, stride_y, fractions, out);
#endif
  (void)lanes;
  by_two::cubic(corner, stride_x, stride_y, fractions, out);
}

}  // namespace typodont::haptics
