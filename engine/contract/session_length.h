// Upper limit for the length of a session.
#pragma once

namespace typodont {

/// Longest session, s: one day, about 20 GiB at 1 kHz. Anything longer is probably a mistake.
inline constexpr double kLongestSession = 86400;

}  // namespace typodont
