// Version of the servo's force law, stored in recordings.
#pragma once

#include <cstdint>

namespace typodont {

/// Raise it in the commit that changes the bits of a force or a cut, and delete the old law in that commit.
inline constexpr std::uint64_t kForceLaw = 1;

}  // namespace typodont
