// Functions of one float or of eight floats. A template that calls them computes the same bits for one number and for
// eight numbers at a time. Every file that includes this header is compiled with -Wno-psabi, because vectors of eight
// floats are passed only between inlined functions.
#pragma once

#include <cmath>

#include "engine/base/vectors.h"

namespace typodont::surface {

TYPODONT_INLINE float absolute(float v) {
  return std::abs(v);
}
TYPODONT_INLINE Eight absolute(Eight v) {
  return reinterpret_cast<Eight>(reinterpret_cast<EightInts>(v) & 0x7fffffff);
}

TYPODONT_INLINE float root(float v) {
  return std::sqrt(v);
}
TYPODONT_INLINE Eight root(Eight v) {
  asm("" : "+m"(v));  // writes and reads v; otherwise the compiler would compute some of the roots one by one
  Eight out;
  for (int i = 0; i < 8; ++i) out[i] = std::sqrt(v[i]);
  return out;
}

template <class Real>
TYPODONT_INLINE Real limited(Real v, float low, float high) {
  const Real lowest = Real{} + low, highest = Real{} + high;
  return v < lowest ? lowest : highest < v ? highest : v;
}

/// Returns one bit for each lane of a comparison.
TYPODONT_INLINE unsigned bits_of(EightInts mask) {
#ifdef __SSE2__
  const FourInts low = __builtin_shufflevector(mask, mask, 0, 1, 2, 3),
                 high = __builtin_shufflevector(mask, mask, 4, 5, 6, 7);
  return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<Four>(low)) |
                               __builtin_ia32_movmskps(reinterpret_cast<Four>(high)) << 4);
#else
  unsigned bits = 0;
  for (int i = 0; i < 8; ++i) bits |= static_cast<unsigned>(mask[i] != 0) << i;
  return bits;
#endif
}

}  // namespace typodont::surface
