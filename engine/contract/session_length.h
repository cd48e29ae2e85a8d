// Upper limit for the length of a session.
#pragma once

namespace typodont {

/// s: one day. More is taken for a mistake: a day at 1 kHz takes about 20 GiB.
inline constexpr double kLongestSession = 86400;

}  // namespace typodont
