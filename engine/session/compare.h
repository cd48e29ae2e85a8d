// Compares a replayed tick or cut with the recorded one, in the precision of the file.
#pragma once

#include <string_view>

#include "engine/contract/contact.h"

namespace typodont::session {

/// Name of the first column in which two messages differ in any bit; empty: none. Values are rounded as in the file.
/// Skips columns that a replay cannot compute: hand pose, pedal, CPU time, fault bits set by the device or the loop.
std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded);
std::string_view differing_column(const Cut& replayed, const Cut& recorded);

}  // namespace typodont::session
