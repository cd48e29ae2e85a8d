// Operations on eight floats (GCC vector types) or on sixteen (AVX-512). Results are exact or rounded as in IEEE 754,
// so they are bit-identical on every processor. Private to haptics/cutting.
#pragma once

#include <cstdint>

#include "haptics/cutting/lanes.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define TYPODONT_SIXTEEN_LANES 1
#include <immintrin.h>
#endif

// All functions with vector arguments are inlined, so the warning about their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace typodont::haptics {

namespace eight {

using Floats = F8;
using Ints = I8;
using Mask = I8;
constexpr int kLanes = 8;

TYPODONT_INLINE Floats load(const float* p) {
  return *reinterpret_cast<const F8*>(p);
}
TYPODONT_INLINE void store(float* p, Floats v) {
  *reinterpret_cast<F8*>(p) = v;
}
TYPODONT_INLINE Floats all(float v) {
  return F8{} + v;
}
TYPODONT_INLINE Floats as_floats(const std::int32_t* p) {
  return __builtin_convertvector(*reinterpret_cast<const I8*>(p), F8);
}
TYPODONT_INLINE Mask first(int count) {
  return I8{0, 1, 2, 3, 4, 5, 6, 7} < count;
}
TYPODONT_INLINE Mask everywhere() {
  return ~I8{};
}
TYPODONT_INLINE Mask nowhere() {
  return I8{};
}
TYPODONT_INLINE Mask more(Floats a, Floats b) {
  return a > b;
}
TYPODONT_INLINE Mask more_where(Mask where, Floats a, Floats b) {
  return where & (a > b);
}
TYPODONT_INLINE Mask no_less(Floats a, Floats b) {
  return a >= b;
}
TYPODONT_INLINE Floats pick(Mask mask, Floats yes, Floats no) {
  return mask ? yes : no;
}
TYPODONT_INLINE Floats lesser(Floats a, Floats b) {
  return a < b ? a : b;
}
TYPODONT_INLINE Floats greater(Floats a, Floats b) {
  return a > b ? a : b;
}
TYPODONT_INLINE Floats root(Floats v) {
  take_root(v);
  return v;
}
TYPODONT_INLINE bool any_positive(Ints v) {
  return any_of(v > 0);
}
TYPODONT_INLINE bool any(Mask mask) {
  return any_of(mask);
}
TYPODONT_INLINE unsigned bits(Mask mask) {
  return bits_of(mask);
}
TYPODONT_INLINE bool every(Mask mask) {
  return !any_of(~mask);
}

}  // namespace eight

#ifdef TYPODONT_SIXTEEN_LANES
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
// Operations with mask registers. `V`, `I`: vector types of floats and integers; `P`: prefix of intrinsics; `COUNT`:
// lanes; `M`: mask type. Some use masked instructions, because GCC 12 warns wrongly about the unmasked ones.
#define TYPODONT_MASKED_LANES(V, I, P, COUNT, M)                          \
  using Floats = V;                                                       \
  typedef int Ints __attribute__((vector_size(4 * COUNT)));               \
  using Mask = unsigned;                                                  \
  constexpr int kLanes = COUNT;                                           \
  constexpr M kEvery = (1u << COUNT) - 1;                                 \
  TYPODONT_INLINE Floats load(const float* p) {                           \
    return P##_loadu_ps(p);                                               \
  }                                                                       \
  TYPODONT_INLINE void store(float* p, Floats v) {                        \
    P##_storeu_ps(p, v);                                                  \
  }                                                                       \
  TYPODONT_INLINE Floats all(float v) {                                   \
    return P##_set1_ps(v);                                                \
  }                                                                       \
  TYPODONT_INLINE Floats as_floats(const std::int32_t* p) {               \
    return P##_maskz_cvtepi32_ps(kEvery, P##_loadu_epi32(p));             \
  }                                                                       \
  TYPODONT_INLINE Mask first(int count) {                                 \
    return (1u << count) - 1;                                             \
  }                                                                       \
  TYPODONT_INLINE Mask everywhere() {                                     \
    return kEvery;                                                        \
  }                                                                       \
  TYPODONT_INLINE Mask nowhere() {                                        \
    return 0;                                                             \
  }                                                                       \
  TYPODONT_INLINE Mask more(Floats a, Floats b) {                         \
    return P##_cmp_ps_mask(a, b, _CMP_GT_OQ);                             \
  }                                                                       \
  TYPODONT_INLINE Mask more_where(Mask where, Floats a, Floats b) {       \
    return P##_mask_cmp_ps_mask(static_cast<M>(where), a, b, _CMP_GT_OQ); \
  }                                                                       \
  TYPODONT_INLINE Mask no_less(Floats a, Floats b) {                      \
    return P##_cmp_ps_mask(a, b, _CMP_GE_OQ);                             \
  }                                                                       \
  TYPODONT_INLINE Floats pick(Mask mask, Floats yes, Floats no) {         \
    return P##_mask_blend_ps(static_cast<M>(mask), no, yes);              \
  }                                                                       \
  TYPODONT_INLINE Floats lesser(Floats a, Floats b) {                     \
    return P##_maskz_min_ps(kEvery, a, b);                                \
  }                                                                       \
  TYPODONT_INLINE Floats greater(Floats a, Floats b) {                    \
    return P##_maskz_max_ps(kEvery, a, b);                                \
  }                                                                       \
  TYPODONT_INLINE Floats root(Floats v) {                                 \
    return P##_maskz_sqrt_ps(kEvery, v);                                  \
  }                                                                       \
  TYPODONT_INLINE bool any_positive(Ints v) {                             \
    return P##_test_epi32_mask((I)v, (I)v) != 0;                          \
  }                                                                       \
  TYPODONT_INLINE bool any(Mask mask) {                                   \
    return mask != 0;                                                     \
  }                                                                       \
  TYPODONT_INLINE unsigned bits(Mask mask) {                              \
    return mask;                                                          \
  }                                                                       \
  TYPODONT_INLINE bool every(Mask mask) {                                 \
    return (mask & kEvery) == kEvery;                                     \
  }

namespace sixteen {
TYPODONT_MASKED_LANES(__m512, __m512i, _mm512, 16, __mmask16)
}  // namespace sixteen

/// Eight lanes with mask registers (AVX-512), for rows of at most eight samples.
namespace eight_masked {
TYPODONT_MASKED_LANES(__m256, __m256i, _mm256, 8, __mmask8)
}  // namespace eight_masked
#undef TYPODONT_MASKED_LANES
#pragma GCC pop_options
#endif

}  // namespace typodont::haptics
