// Vectors of eight floats for kernels that are compiled for several instruction sets (engine/base/dispatch.h). GCC's
// vector types give equal results on all. Only for .cpp files of haptics.
#pragma once

#include <cmath>
#include <cstring>

#include "engine/base/vectors.h"

namespace typodont::haptics {

typedef float F8 __attribute__((vector_size(32), aligned(4), may_alias));
typedef int I8 __attribute__((vector_size(32), aligned(4), may_alias));
typedef unsigned char B8 __attribute__((vector_size(8), aligned(1), may_alias));
typedef double D4 __attribute__((vector_size(32), aligned(8), may_alias));
typedef double D8 __attribute__((vector_size(64), aligned(8), may_alias));
typedef long long L8 __attribute__((vector_size(64), aligned(8), may_alias));
typedef float F4 __attribute__((vector_size(16), aligned(4), may_alias));
typedef int I4 __attribute__((vector_size(16), aligned(4), may_alias));

using typodont::bits_of;

/// Returns a number with one bit for each lane of the mask.
TYPODONT_INLINE unsigned bits_of(const L8& mask) {
  return bits_of(__builtin_convertvector(mask, I8));
}

TYPODONT_INLINE void read_lanes(D8& v, const double* from) {
  std::memcpy(&v, from, sizeof v);
}
TYPODONT_INLINE void write_lanes(double* to, const D8& v) {
  std::memcpy(to, &v, sizeof v);
}

TYPODONT_INLINE bool any_of(const I8& mask) {
#ifdef __SSE2__
  const I4 both = __builtin_shufflevector(mask, mask, 0, 1, 2, 3) | __builtin_shufflevector(mask, mask, 4, 5, 6, 7);
  return __builtin_ia32_movmskps((F4)both) != 0;
#else
  return bits_of(mask) != 0;
#endif
}

TYPODONT_INLINE void take_root(D8& v) {
  asm("" : "+m"(v));  // stores v in memory; otherwise some roots are computed one by one
  D8 root;
  for (int i = 0; i < 8; ++i) root[i] = std::sqrt(v[i]);
  v = root;
}
TYPODONT_INLINE void take_root(F8& v) {
  // Stores v in memory; otherwise the compiler splits the vector and computes some of the roots one by one.
  asm("" : "+m"(v));
  F8 root;
  for (int i = 0; i < 8; ++i) root[i] = std::sqrt(v[i]);
  v = root;
}

/// `order[mask]` moves the lanes in `mask` to the front.
struct Compaction {
  I8 order[256] = {};
  Compaction() {
    for (int mask = 0; mask < 256; ++mask) {
      for (int lane = 0, next = 0; lane < 8; ++lane) {
        if (mask >> lane & 1) order[mask][next++] = lane;
      }
    }
  }
};
inline const Compaction kCompaction;

TYPODONT_INLINE void gather_lanes(const F8& v, const I8& order, F8& first) {
#ifdef __clang__  // clang has no shuffle with variable indices
  for (int i = 0; i < 8; ++i) first[i] = v[order[i]];
#else
  first = __builtin_shuffle(v, order);
#endif
}

TYPODONT_INLINE float least_of(const F8& v) {
  const F8 four = __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3), a = v < four ? v : four,
           two = __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5), b = a < two ? a : two;
  return b[0] < b[1] ? b[0] : b[1];
}

TYPODONT_INLINE float sum_of(const F8& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

}  // namespace typodont::haptics
