// How long a session may be.
#pragma once

namespace typodont {

/// s: a day. What is said to be longer (a hand's path, --seconds) is a mistake, and would fill any disk: at 1 kHz a day
/// of ticks is a recording of some 20 GiB.
inline constexpr double kLongestSession = 86400;

}  // namespace typodont
