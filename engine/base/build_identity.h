#pragma once

#include <cstdint>

namespace typodont {

/// Hash of all sources, compiler and options that can change a result; not of tests, shaders or data. Builds with equal
/// hashes may share cached results.
std::uint64_t build_identity() noexcept;

}  // namespace typodont
