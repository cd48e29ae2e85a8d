// Vectors of four or eight numbers, which the compiler keeps in vector registers. With GCC's vector types, the results
// are the same on every processor.
#pragma once

namespace typodont {

using Four = float __attribute__((vector_size(16)));
using FourInts = int __attribute__((vector_size(16)));
using Eight = float __attribute__((vector_size(32)));
using EightInts = int __attribute__((vector_size(32)));

/// Marks a function that is always inlined, so that it is compiled for the processor type of its caller (dispatch.h).
#define TYPODONT_INLINE inline __attribute__((always_inline))

}  // namespace typodont
