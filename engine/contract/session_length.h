// Upper limit for the length of a session.
#pragma once

namespace typodont {

/// s, one day. A longer request (a recorded hand path, --seconds) is treated as a mistake, because it would fill any
/// disk: at 1 kHz a day of ticks is a recording of about 20 GiB.
inline constexpr double kLongestSession = 86400;

}  // namespace typodont
