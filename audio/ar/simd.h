// Vectors of fixed length for SIMD instructions. The operations and their order do not depend on the processor's vector
// length, so the sound has the same bits on every processor. (The build forbids contraction to fused multiply-add.)
#pragma once

#include <cstdint>

#include "engine/base/dispatch.h"

namespace typodont::audio {

using Float16 = float __attribute__((vector_size(64)));
using Double8 = double __attribute__((vector_size(64)));
using UInt16x = std::uint32_t __attribute__((vector_size(64)));
using Int16x = std::int32_t __attribute__((vector_size(64)));
using Float16Unaligned = float __attribute__((vector_size(64), aligned(4), may_alias));
using Double8Unaligned = double __attribute__((vector_size(64), aligned(8), may_alias));

// Compiles a function once for each generation of processors; the program selects the copy when it starts.
#define TYPODONT_CLONES TYPODONT_DISPATCH("default", "arch=x86-64-v3", "arch=x86-64-v4")

}  // namespace typodont::audio
