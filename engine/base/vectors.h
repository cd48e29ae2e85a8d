// Vectors of four or eight numbers in processor registers. GCC's vector types give the same results on every processor.
#pragma once

namespace typodont {

using Four = float __attribute__((vector_size(16)));
using FourInts = int __attribute__((vector_size(16)));
using Eight = float __attribute__((vector_size(32)));
using EightInts = int __attribute__((vector_size(32)));

/// Always inlined, so that the function is compiled for the caller's processor type (dispatch.h).
#define TYPODONT_INLINE inline __attribute__((always_inline))

/// The result of a comparison as one bit per lane.
TYPODONT_INLINE unsigned bits_of(const EightInts& mask) {
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

}  // namespace typodont
