// A replayed tick or cut against the recorded one, in the file's precision.
#pragma once

#include <string_view>

#include "engine/contract/contact.h"

namespace typodont::session {

/// First column that differs in a bit; empty: none. Skips what the servo does not compute: hand, pedal, CPU time, fault
/// bits of other code. Units other than SI are rounded as in the file.
std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded);
std::string_view differing_column(const Cut& replayed, const Cut& recorded);

}  // namespace typodont::session
