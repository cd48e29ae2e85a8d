// Compares a replayed tick or cut with the recorded one, in the precision of the file.
#pragma once

#include <string_view>

#include "engine/contract/contact.h"

namespace typodont::session {

/// Name of the first column with a different bit; empty: none. Skips what the servo does not compute: hand, pedal, CPU
/// time, and fault bits of other code. Values in other units than SI are rounded as in the file.
std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded);
std::string_view differing_column(const Cut& replayed, const Cut& recorded);

}  // namespace typodont::session
