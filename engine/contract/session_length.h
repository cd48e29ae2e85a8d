// Upper limit for the length of a session.
#pragma once

namespace typodont {

/// s, longest session: one day. A longer time (of a recorded hand path or of --seconds) is treated as a mistake,
/// because the recording would fill any disk: a day at 1 kHz takes about 20 GiB.
inline constexpr double kLongestSession = 86400;

}  // namespace typodont
