#pragma once

#include <cstdint>

namespace typodont {

/// Returns a hash of the sources of the library and the program, of the compiler, and of the compiler options. Programs
/// with the same value compute the same results from the same input, so they can share cached results. The value does
/// not depend on tests, shaders and data files.
std::uint64_t build_identity() noexcept;

}  // namespace typodont
