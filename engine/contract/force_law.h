// Version of the servo's force law, stored in recordings.
#pragma once

#include <cstdint>

namespace typodont {

/// Version of the force law. A commit that changes any bit of a force or cut must raise it and delete the old law.
inline constexpr std::uint64_t kForceLaw = 9;

}  // namespace typodont
