#pragma once

#include <cstdint>

namespace typodont {

/// Hash of the library's and program's sources, the compiler and its options; not of tests, shaders and data. Equal
/// values compute equal results, so they can share a cache.
std::uint64_t build_identity() noexcept;

}  // namespace typodont
