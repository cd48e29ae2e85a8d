// Functions of one float or of eight floats at once, with bit-identical results. Compile the files that include this
// one with -Wno-psabi: vectors are passed only between inlined functions.
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
  asm("" : "+m"(v));  // otherwise the compiler computes some square roots one at a time
  Eight out;
  for (int i = 0; i < 8; ++i) out[i] = std::sqrt(v[i]);
  return out;
}

template <class Real>
TYPODONT_INLINE Real limited(Real v, float low, float high) {
  const Real lowest = Real{} + low, highest = Real{} + high;
  return v < lowest ? lowest : highest < v ? highest : v;
}

}  // namespace typodont::surface
