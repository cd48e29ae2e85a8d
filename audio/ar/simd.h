// Vectors of fixed length. Every processor executes the same operations in the same order, without fused multiply-add,
// so results are bit-identical.
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

// Compiles a function once per processor generation; the program selects the copy for this processor at its start.
#define TYPODONT_CLONES TYPODONT_DISPATCH("default", "arch=x86-64-v3", "arch=x86-64-v4")

}  // namespace typodont::audio
